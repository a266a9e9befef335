// SPDX-License-Identifier: Apache-2.0
// Order of the stage: black frames, then every band by itself, then noise, resampling and alignment of all
// together.
#include "calibrate/calibrate.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

#include "calibrate/band_frames.h"
#include "calibrate/spectralon.h"
#include "calibrate/statistics.h"
#include "common/core/error.h"
#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr double kWindowSizes =
    0.04;  // deviation of a window's size from the bands' median: not the same window
constexpr double kSaturatedNote = 0.001;
constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

// Steps done, from several threads, as a fraction that only grows.
class Steps {
 public:
  Steps(int total, const ProgressFunction& progress) : total_(total), progress_(progress) {}
  void Done() {
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    progress_(std::min(1.0, double(++done_) / total_));
  }

 private:
  std::mutex mutex_;
  int done_ = 0;
  int total_;
  const ProgressFunction& progress_;
};

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

struct PatchBand {
  PlaneF reflectance;
  PlaneF sigma;
};

// Mean of the band's skin frames. Their own noise averages out, that of the one Spectralon mean does not.
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
        n > 0.0f ? std::sqrt(skin_variance.data()[i] / (n * n) + spectralon_variance.data()[i] / n)
                 : kMissing;
  }
  return sum;
}

// A window of another size than the other bands' is another thing: that band is left out, by name.
void DropStrangeWindows(std::vector<BandFrames>& bands) {
  std::vector<float> sizes;
  for (const BandFrames& band : bands)
    sizes.push_back(static_cast<float>(band.record.windows[0].largest_side_px));
  const double usual = Median(sizes);
  for (BandFrames& band : bands) {
    for (const Window& window : band.record.windows) {
      if (band.record.dropped || std::abs(window.largest_side_px / usual - 1.0) <= kWindowSizes) continue;
      band.record.dropped = true;
      band.record.notes.push_back("left out: its window is " + Short(window.largest_side_px) +
                                  " photosites wide, that of the other bands " + Short(usual));
    }
  }
}

void Align(std::vector<BandFrames>& bands, std::vector<PatchBand>& patches,
           const CalibrationOptions& options) {
  std::vector<std::size_t> kept;
  std::vector<PlaneF> reflectance;
  std::vector<PlaneF> sigma;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (bands[i].record.dropped) continue;
    kept.push_back(i);
    reflectance.push_back(patches[i].reflectance);
    sigma.push_back(patches[i].sigma);
  }
  const auto found = AlignBands(reflectance, sigma, options.alignment);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    BandCalibration& record = bands[kept[k]].record;
    record.alignment = found[k];
    if (!found[k].note.empty())
      record.notes.push_back((found[k].clearly_off ? "left out: " : "") + found[k].note);
    record.dropped = found[k].clearly_off;
  }
}

PlaneF ValidPixels(const std::vector<PlaneF>& reflectance, double edge_mask_px) {
  const int width = reflectance[0].width();
  const int height = reflectance[0].height();
  PlaneF valid(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double edge = 0.5 + std::min({x, y, width - 1 - x, height - 1 - y});
      const bool any = std::any_of(reflectance.begin(), reflectance.end(),
                                   [&](const PlaneF& band) { return !std::isnan(band(x, y)); });
      valid(x, y) = any && edge > edge_mask_px ? 1.0f : 0.0f;
    }
  }
  return valid;
}

double MedianOfValid(const PlaneF& plane, const PlaneF& valid) {
  std::vector<float> values;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    if (valid.data()[i] > 0.0f && !std::isnan(plane.data()[i])) values.push_back(plane.data()[i]);
  }
  return Median(std::move(values));
}

NoiseCorrelation MeanCorrelation(const std::vector<BandCalibration>& bands) {
  NoiseCorrelation mean{std::vector<double>(NoiseCorrelation::kReach + 1), {}, 0.0};
  mean.along_y = mean.along_x;
  const auto kept = std::count_if(bands.begin(), bands.end(), [](const auto& band) { return !band.dropped; });
  for (const BandCalibration& band : bands) {
    if (band.dropped) continue;
    const double share = 1.0 / static_cast<double>(kept);
    for (std::size_t i = 0; i < mean.along_x.size(); ++i) {
      mean.along_x[i] += share * band.correlation.along_x[i];
      mean.along_y[i] += share * band.correlation.along_y[i];
    }
    mean.diagonal += share * band.correlation.diagonal;
  }
  return mean;
}

void Assemble(std::vector<BandFrames>& bands, std::vector<PatchBand>& patches, const Session& session,
              const CalibrationOptions& options, CalibrationResult& result) {
  ReflectanceStack& stack = result.stack;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (bands[i].record.dropped) continue;
    stack.bands.push_back(bands[i].record.band);
    stack.reflectance.push_back(std::move(patches[i].reflectance));
    stack.sigma.push_back(std::move(patches[i].sigma));
  }
  if (stack.bands.empty()) {
    throw InputError(session.directory.string() +
                     ": no band is left after alignment; expected windows of one size that "
                     "show one patch of skin: capture the session again");
  }
  stack.valid = ValidPixels(stack.reflectance, options.edge_mask_px);
  stack.pixel_size_mm = session.rig.window_mm / options.patch_px;
  stack.illumination = Illumination::kWindow;
  stack.tape = Tape::kFree;
  stack.geometry = Geometry::kFactor0_30;
  std::size_t k = 0;
  for (BandFrames& band : bands) {
    if (!band.record.dropped) {
      band.record.median_reflectance = MedianOfValid(stack.reflectance[k], stack.valid);
      band.record.median_noise = MedianOfValid(stack.sigma[k], stack.valid);
      ++k;
    }
    if (band.record.saturated_share > kSaturatedNote) {
      band.record.notes.push_back(Short(100 * band.record.saturated_share) +
                                  " % of the window's photosites are saturated and left out: lower the ISO");
    }
    result.bands.push_back(std::move(band.record));
  }
  result.correlation = MeanCorrelation(result.bands);
  const auto lags = [](const std::vector<double>& from_zero) {
    return std::vector<float>(from_zero.begin() + 1, from_zero.end());
  };
  stack.noise_correlation_x = lags(result.correlation.along_x);
  stack.noise_correlation_y = lags(result.correlation.along_y);
}

void NoteMissingBands(const Session& session, const std::vector<Band>& bands,
                      std::vector<std::string>& notes) {
  if (!session.complete)
    notes.push_back("the session is not complete: some planned frames were never captured");
  for (const WheelSlot& slot : session.rig.slots) {
    const bool planned = std::any_of(session.plan.exposures.begin(), session.plan.exposures.end(),
                                     [&](const auto& e) { return e.slot == slot.slot; });
    const bool there = std::any_of(bands.begin(), bands.end(),
                                   [&](const Band& b) { return b.wavelength_nm == slot.wavelength_nm; });
    if (planned && !slot.opaque && !there)
      notes.push_back("no skin frame at " + Short(slot.wavelength_nm) + " nm");
  }
}

}  // namespace

CalibrationResult CalibrateFrames(const Session& session, const FrameReader& read,
                                  const CalibrationOptions& options, const ProgressFunction& progress) {
  CalibrationResult result;
  result.session = session.directory.filename().string();
  result.edge_mask_px = options.edge_mask_px;
  const std::vector<Band> bands = BandsOfSession(session);
  NoteMissingBands(session, bands, result.notes);
  const auto count = static_cast<int>(bands.size());
  const BlackFrames blacks(session, read);
  result.hot_share = blacks.hot_share();
  const SampledSpectrum certificate = ReadCertificate(session.rig);
  const SessionContext context{session, read, blacks,
                               GrayCardRegion(session.rig, blacks.sensor().width, blacks.sensor().height)};
  Steps steps(3 * count, progress);
  std::vector<BandFrames> frames(bands.size());
  ParallelFor(count, [&](int i) {
    const double white = CertifiedReflectance(certificate, bands[i]) * options.spectralon_factor;
    frames[i] = PrepareBand(context, bands[i], white);
    steps.Done();
  });
  DropStrangeWindows(frames);
  result.noise = NoiseOfSession(blacks, frames, result.notes);
  std::vector<PatchBand> patches(bands.size());
  ParallelFor(count, [&](int i) {
    patches[i] = ResampleBand(frames[i], result.noise, options.patch_px);
    frames[i].record.correlation =
        CorrelationOfNoise(frames[i].skins[0].mosaic, frames[i].record.windows[0].camera_from_unit,
                           NoiseOf(frames[i].skins[0], result.noise), options.patch_px);
    steps.Done();
  });
  if (options.align) Align(frames, patches, options);
  ParallelFor(count, [&](int i) {  // from the photosites again, so that nothing is interpolated twice
    if (frames[i].record.alignment.applied)
      patches[i] = ResampleBand(frames[i], result.noise, options.patch_px);
    steps.Done();
  });
  Assemble(frames, patches, session, options, result);
  return result;
}

CalibrationResult CalibrateSession(const Session& session, const CalibrationOptions& options,
                                   const ProgressFunction& progress) {
  if (options.verify_hashes) VerifyFrames(session);
  const FrameReader read = [&](const FrameRecord& record) {
    return ReadBayerFrame(session.directory / record.file);
  };
  return CalibrateFrames(session, read, options, progress);
}

}  // namespace dermap
