// SPDX-License-Identifier: Apache-2.0
// Noise of the session's frames, and the mean of a band's frames on the patch.
#include "calibrate/band_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/error.h"

namespace dermap {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

const NoiseModel& ModelOf(const std::map<int, NoiseModel>& models, int iso) {
  const auto found = models.find(iso);
  if (found != models.end()) return found->second;
  return std::min_element(models.begin(), models.end(),
                          [&](const auto& a, const auto& b) {
                            return std::abs(std::log(double(a.first) / iso)) <
                                   std::abs(std::log(double(b.first) / iso));
                          })
      ->second;
}

MosaicNoise NoiseOf(const SkinMosaic& skin, const std::map<int, NoiseModel>& models) {
  return {ModelOf(models, skin.skin_iso),
          ModelOf(models, skin.spectralon_iso),
          skin.spectralon_frames,
          skin.shared_black,
          skin.skin_black,
          skin.spectralon_black};
}

// The skin frames are divided by one Spectralon mean, so its noise does not average out as theirs does, but where the
// subject moved between frames, a pixel of the patch has met other photosites of it. The share of the variance that is
// left: mean correlation between all pairs of frames, by how far the windows' middles lie apart.
double SharedSpectralon(const BandCalibration& record, int patch_px) {
  double sum = 0.0;
  for (const Window& a : record.windows) {
    const Homography unit_from_camera = a.camera_from_unit.Inverse();
    for (const Window& b : record.windows) {
      const Point p = unit_from_camera(b.camera_from_unit({0.5, 0.5}));
      const double lag = std::hypot(p.x - 0.5, p.y - 0.5) * patch_px;
      const auto& table = record.correlation.along_x;
      const auto k = static_cast<std::size_t>(lag);
      if (k + 1 < table.size()) sum += table[k] + (lag - std::floor(lag)) * (table[k + 1] - table[k]);
    }
  }
  const auto n = static_cast<double>(record.windows.size());
  return sum / (n * n);
}

}  // namespace

std::map<int, NoiseModel> NoiseOfSession(const BlackFrames& blacks, const std::vector<BandFrames>& bands,
                                         std::vector<std::string>& notes) {
  std::vector<PhotonTransferPoint> pairs = PhotonTransferOfBlack(blacks);
  std::vector<PhotonTransferPoint> singles;
  for (const BandFrames& band : bands) {
    pairs.insert(pairs.end(), band.pairs.begin(), band.pairs.end());
    singles.insert(singles.end(), band.singles.begin(), band.singles.end());
  }
  std::map<int, NoiseModel> models = FitNoise(pairs);
  for (const auto& [iso, model] : FitNoise(singles)) {
    if (!models.emplace(iso, model).second) continue;
    notes.push_back(
        "noise at ISO " + std::to_string(iso) +
        " was estimated from single frames, the gray card's texture counted in: sigma is an upper bound");
  }
  if (models.empty()) {
    throw InputError(
        "the gray card has too few usable photosites to tell the noise; expected a card that is lit and not "
        "saturated: check gray_card_region in the rig's file");
  }
  return models;
}

PatchBand ResampleBand(const BandFrames& band, const std::map<int, NoiseModel>& models, int patch_px) {
  const BandAlignment& a = band.record.alignment;
  const Homography motion = UnitMotion(a.dx_px / patch_px, a.dy_px / patch_px, a.angle_rad);
  PatchBand sum{PlaneF(patch_px, patch_px), PlaneF(patch_px, patch_px)};
  PlaneF skin_variance(patch_px, patch_px), spectralon_variance(patch_px, patch_px),
      count(patch_px, patch_px);
  for (std::size_t k = 0; k < band.skins.size(); ++k) {
    const Homography camera_from_unit = band.record.windows[k].camera_from_unit.After(motion);
    const ResampledPatch patch =
        ResamplePatch(band.skins[k].mosaic, camera_from_unit, NoiseOf(band.skins[k], models), patch_px);
    for (std::size_t i = 0; i < count.size(); ++i) {
      if (std::isnan(patch.reflectance.data()[i])) continue;
      count.data()[i] += 1.0f;
      sum.reflectance.data()[i] += patch.reflectance.data()[i];
      skin_variance.data()[i] += patch.skin_variance.data()[i];
      spectralon_variance.data()[i] += patch.spectralon_variance.data()[i];
    }
  }
  for (std::size_t i = 0; i < count.size(); ++i) {
    const float n = count.data()[i];
    sum.reflectance.data()[i] = n > 0.0f ? sum.reflectance.data()[i] / n : kMissing;
    sum.sigma.data()[i] =
        n > 0.0f ? static_cast<float>(std::sqrt(skin_variance.data()[i] / (n * n) + shared * spectralon_variance.data()[i] / n))
                 : kMissing;
  }
  return sum;
}

NoiseCorrelation CorrelationOfBand(const BandFrames& band, const std::map<int, NoiseModel>& models, int patch_px) {
  return CorrelationOfNoise(band.skins[0].mosaic, band.record.windows[0].camera_from_unit,
                            NoiseOf(band.skins[0], models), patch_px);
}

}  // namespace dermap
