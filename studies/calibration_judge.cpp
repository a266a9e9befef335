// SPDX-License-Identifier: Apache-2.0
// Levels of patches, places of bands, and skin as a pixel averages it.
#include "studies/calibration_judge.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

constexpr int kFieldMargin_px = 8;  // of a patch's field: the lens blurs its neighbours into it
constexpr int kGrid = 9;            // points a side at which bands are compared
constexpr double kGridBorder = 0.08;

// Where the skin at a point of the patch was found, against where it is: patch pixels.
Point2 PlaceError(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                  const BandCalibration& band, Point unit) {
  const auto frame = std::find_if(session.frames.begin(), session.frames.end(), [&](const FrameRecord& f) {
    return f.role == FrameRole::kSkin && f.wavelength_nm == band.band.wavelength_nm;
  });
  const double size = result.stack.valid.width();
  const PatchMap map{band.windows[0].camera_from_unit, band.alignment.warp, size};
  const BenchConfig& config = bench.scene().bench;
  const Lens lens{0.5 * config.width_px, 0.5 * config.height_px,
                  0.5 * std::hypot(config.width_px, config.height_px), session.rig.optics.distortion_k1, 0.0};
  const Point found = lens.PhotositesFromIdeal(map(unit));
  const double window_mm = session.rig.window_mm;
  const Point2 skin = PatchFromBench(bench.PoseOfShot(ShotOf(*frame)), window_mm,
                                     bench.view().BenchFromPixel({found.x - 0.5, found.y - 0.5}));
  return {(skin.x / window_mm - unit.x) * size, (skin.y / window_mm - unit.y) * size};
}

// Weights of a Gaussian around 0; what they miss of it is 1e-5.
std::vector<double> GaussianWeights(double variance) {
  const int reach = std::max(1, static_cast<int>(std::ceil(4.4 * std::sqrt(variance))));
  std::vector<double> weights;
  for (int i = -reach; i <= reach; ++i) weights.push_back(std::exp(-0.5 * i * i / variance));
  return weights;
}

// Along x (or y), the border's value going on beyond it.
PlaneF BlurredAlong(const PlaneF& plane, const std::vector<double>& weights, bool along_x) {
  PlaneF out(plane.width(), plane.height());
  const int reach = static_cast<int>(weights.size() / 2);
  double total = 0.0;
  for (const double w : weights) total += w;
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      double sum = 0.0;
      for (int i = -reach; i <= reach; ++i) {
        const int sx = std::clamp(along_x ? x + i : x, 0, plane.width() - 1);
        const int sy = std::clamp(along_x ? y : y + i, 0, plane.height() - 1);
        sum += weights[static_cast<std::size_t>(i + reach)] * plane(sx, sy);
      }
      out(x, y) = static_cast<float>(sum / total);
    }
  }
  return out;
}

// The truth as a pixel averages it. Two terms of the Taylor series in place of the Gaussian would blur
// freckles a tenth too much.
PlaneF Averaged(const PlaneF& truth, double variance_x, double variance_y) {
  return BlurredAlong(BlurredAlong(truth, GaussianWeights(variance_x), true), GaussianWeights(variance_y),
                      false);
}

double Chi2(const ReflectanceStack& stack, std::size_t band, const PlaneF& truth) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < stack.valid.size(); ++i) {
    const float r = stack.reflectance[band].data()[i];
    if (stack.valid.data()[i] == 0.0f || std::isnan(r)) continue;
    sum += std::pow((r - truth.data()[i]) / stack.sigma[band].data()[i], 2);
    count += 1.0;
  }
  return sum / std::max(1.0, count);
}

}  // namespace

Shot ShotOf(const FrameRecord& record) {
  return {record.role, record.slot, record.exposure_ms, record.iso, record.number};
}

void JudgePatches(const CalibrationResult& result, const std::vector<double>& patches,
                  CalibrationStudyRig& rig) {
  const int columns = 4;
  const int rows = static_cast<int>(patches.size()) / columns;
  const int size = result.stack.valid.width();
  for (const PlaneF& plane : result.stack.reflectance) {
    for (std::size_t field = 0; field < patches.size(); ++field) {
      const int column = static_cast<int>(field) % columns, row = static_cast<int>(field) / columns;
      double sum = 0.0;
      int count = 0;
      for (int y = row * size / rows + kFieldMargin_px; y < (row + 1) * size / rows - kFieldMargin_px; ++y) {
        for (int x = column * size / columns + kFieldMargin_px;
             x < (column + 1) * size / columns - kFieldMargin_px; ++x) {
          if (result.stack.valid(x, y) == 0.0f || std::isnan(plane(x, y))) continue;
          sum += plane(x, y);
          ++count;
        }
      }
      const double error = std::abs(sum / std::max(1, count) - patches[field]);
      rig.bias = std::max(rig.bias, error);
      if (patches[field] == 0.18 || patches[field] == 0.5)
        rig.bias_mid_gray = std::max(rig.bias_mid_gray, error);
    }
  }
}

void JudgeAlignment(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                    CalibrationStudyRig& rig) {
  std::vector<double> square(result.bands.size(), 0.0);
  double common = 0.0;
  for (int j = 0; j < kGrid * kGrid; ++j) {
    const auto place = [](int i) { return kGridBorder + (1.0 - 2.0 * kGridBorder) * i / (kGrid - 1.0); };
    const Point unit{place(j % kGrid), place(j / kGrid)};
    std::vector<Point2> errors;
    Point2 mean;
    for (const BandCalibration& band : result.bands) {
      if (band.dropped) continue;
      errors.push_back(PlaceError(bench, session, result, band, unit));
      mean.x += errors.back().x, mean.y += errors.back().y;
    }
    mean.x /= double(errors.size()), mean.y /= double(errors.size());
    common += (mean.x * mean.x + mean.y * mean.y) / (kGrid * kGrid);
    for (std::size_t b = 0; b < errors.size(); ++b) {
      square[b] += (std::pow(errors[b].x - mean.x, 2) + std::pow(errors[b].y - mean.y, 2)) / (kGrid * kGrid);
    }
  }
  rig.alignment_error_px = std::sqrt(*std::max_element(square.begin(), square.end()));
  rig.window_error_px = std::sqrt(common);
}

void JudgeSkin(const std::vector<PlaneF>& truth, const std::vector<Band>& bands,
               const CalibrationResult& result, CalibrationStudyRig& rig) {
  constexpr double kDrawn =
      1.0 / 6.0;  // variance that the bench's own linear interpolation of the patch adds
  const ReflectanceStack& stack = result.stack;
  std::size_t k = 0;
  for (const BandCalibration& band : result.bands) {
    rig.dropped_bands += band.dropped ? 1 : 0;
    if (band.dropped) continue;
    std::size_t t = 0;
    while (bands[t].wavelength_nm != band.band.wavelength_nm) ++t;
    const double share = 1.0 / static_cast<double>(stack.bands.size());
    const PlaneF seen = Averaged(truth[t], band.blur_px.x * band.blur_px.x + kDrawn,
                                 band.blur_px.y * band.blur_px.y + kDrawn);
    rig.chi2_per_dof += share * Chi2(stack, k, seen);
    rig.chi2_sharp += share * Chi2(stack, k, truth[t]);
    ++k;
  }
}

}  // namespace dermap
