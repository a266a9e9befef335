// SPDX-License-Identifier: Apache-2.0
// Levels of patches, places of bands, and skin as a pixel averages it.
#include "studies/calibration_judge.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace dermap {
namespace {

constexpr int kFieldMargin_px = 8;  // of a patch's field: the lens blurs its neighbours into it
constexpr int kGrid = 9;            // points a side at which bands are compared
constexpr double kGridBorder = 0.08;

const FrameRecord& SkinFrameOf(const Session& session, const BandCalibration& band) {
  return *std::find_if(session.frames.begin(), session.frames.end(), [&](const FrameRecord& f) {
    return f.role == FrameRole::kSkin && f.wavelength_nm == band.band.wavelength_nm;
  });
}

// Where the skin at a point of the patch was found, against where it is: patch pixels.
Point2 PlaceError(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                  const BandCalibration& band, Point unit) {
  const double size = result.stack.valid.width();
  const PatchMap map{band.windows[0].camera_from_unit, band.alignment.warp, size};
  const BenchConfig& config = bench.scene().bench;
  const Lens lens{0.5 * config.width_px, 0.5 * config.height_px,
                  0.5 * std::hypot(config.width_px, config.height_px), session.rig.optics.distortion_k1, 0.0};
  const Point found = lens.PhotositesFromIdeal(map(unit));
  const double window_mm = session.rig.window_mm;
  const Point2 skin = PatchFromBench(bench.PoseOfShot(ShotOf(SkinFrameOf(session, band))), window_mm,
                                     bench.view().BenchFromPixel({found.x - 0.5, found.y - 0.5}));
  return {(skin.x / window_mm - unit.x) * size, (skin.y / window_mm - unit.y) * size};
}

// How far the middle of the skin was displaced under the tape, mean of the shots of the bands that were kept,
// mm. Only what shots differ by is seen in them, never what they have in common: the stack shows skin as it
// lay on average.
Point2 MeanBulge_mm(const OpticalBench& bench, const Session& session, const CalibrationResult& result) {
  Point2 sum;
  double count = 0.0;
  for (const BandCalibration& band : result.bands) {
    if (band.dropped) continue;
    const Pose pose = bench.PoseOfShot(ShotOf(SkinFrameOf(session, band)));
    sum.x += pose.bulge_x_mm, sum.y += pose.bulge_y_mm;
    count += 1.0;
  }
  return {sum.x / std::max(1.0, count), sum.y / std::max(1.0, count)};
}

// Displacement of the window's middle as a share of it elsewhere, as the bench has it.
double Hill(Point unit) {
  return std::sin(std::numbers::pi * unit.x) * std::sin(std::numbers::pi * unit.y);
}

// Gaussian mean along x (or y) around places displaced by hill `shift_px`, the border's value going on beyond
// it. What the weights miss of a Gaussian is 1e-5.
PlaneF BlurredAlong(const PlaneF& plane, double variance, double shift_px, bool along_x) {
  PlaneF out(plane.width(), plane.height());
  const int reach = std::max(1, static_cast<int>(std::ceil(4.4 * std::sqrt(variance) + std::abs(shift_px))));
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      const double off = shift_px * Hill({(x + 0.5) / plane.width(), (y + 0.5) / plane.height()});
      double sum = 0.0, total = 0.0;
      for (int i = -reach; i <= reach; ++i) {
        const double weight = std::exp(-0.5 * (i + off) * (i + off) / variance);
        const int sx = std::clamp(along_x ? x + i : x, 0, plane.width() - 1);
        const int sy = std::clamp(along_x ? y : y + i, 0, plane.height() - 1);
        sum += weight * plane(sx, sy);
        total += weight;
      }
      out(x, y) = static_cast<float>(sum / total);
    }
  }
  return out;
}

// The truth as a pixel averages it, at the place where the skin lay. Two terms of the Taylor series in place
// of the Gaussian would blur freckles a tenth too much.
PlaneF Averaged(const PlaneF& truth, Point2 variance, Point2 bulge_px) {
  return BlurredAlong(BlurredAlong(truth, variance.x, bulge_px.x, true), variance.y, bulge_px.y, false);
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

struct FieldMean {
  double reflectance = 0.0;
  double variance = 0.0;  // as if each pixel's noise were its own
};

// A field of the pattern of steps, without its border.
FieldMean MeanOfField(const ReflectanceStack& stack, std::size_t band, int field, int fields) {
  const int columns = 4;
  const int rows = fields / columns, size = stack.valid.width();
  const int column = field % columns, row = field / columns;
  const PlaneF &plane = stack.reflectance[band], &sigma = stack.sigma[band];
  FieldMean mean;
  double count = 0.0;
  for (int y = row * size / rows + kFieldMargin_px; y < (row + 1) * size / rows - kFieldMargin_px; ++y) {
    for (int x = column * size / columns + kFieldMargin_px;
         x < (column + 1) * size / columns - kFieldMargin_px; ++x) {
      if (stack.valid(x, y) == 0.0f || std::isnan(plane(x, y))) continue;
      mean.reflectance += plane(x, y);
      mean.variance += double(sigma(x, y)) * sigma(x, y);
      count += 1.0;
    }
  }
  mean.reflectance /= std::max(1.0, count);
  mean.variance /= std::max(1.0, count * count);
  return mean;
}

// So many neighbours have one draw of the noise between them.
double PixelsPerDraw(const NoiseCorrelation& correlation) {
  const auto sum = [](const std::vector<double>& from_zero) {
    return 2.0 * std::accumulate(from_zero.begin(), from_zero.end(), 0.0) - from_zero[0];
  };
  return sum(correlation.along_x) * sum(correlation.along_y);
}

// Relative, of what is one number for a session's band: the flash by the gray card, and the nonlinearity,
// which leaves Spectralon alone and is stated for the band's median.
double SharedSigma(const BandCalibration& band, double patch) {
  double square = 0.0;
  for (const StepRecord& step : band.steps) {
    if (step.step == Step::kFlashDrift) square += step.sigma * step.sigma;
    if (step.step == Step::kLinearity)
      square += std::pow(step.sigma * (1.0 - patch) / (1.0 - band.median_reflectance), 2);
  }
  return std::sqrt(square);
}

}  // namespace

Shot ShotOf(const FrameRecord& record) {
  return {record.role, record.slot, record.exposure_ms, record.iso, record.number};
}

std::vector<PatchError> PatchErrors(const CalibrationResult& result, const std::vector<double>& patches) {
  std::vector<PatchError> errors;
  std::size_t k = 0;
  for (const BandCalibration& band : result.bands) {
    if (band.dropped) continue;
    for (std::size_t field = 0; field < patches.size(); ++field) {
      const FieldMean mean =
          MeanOfField(result.stack, k, static_cast<int>(field), static_cast<int>(patches.size()));
      const double shared = patches[field] * SharedSigma(band, patches[field]);
      const double own = std::sqrt(mean.variance * PixelsPerDraw(band.correlation));
      errors.push_back({mean.reflectance - patches[field], std::hypot(own, shared)});
    }
    ++k;
  }
  return errors;
}

void JudgePatches(const std::vector<std::vector<PatchError>>& sessions, const std::vector<double>& patches,
                  CalibrationStudyRig& rig) {
  const double all = static_cast<double>(sessions.size() * sessions[0].size());
  for (std::size_t i = 0; i < sessions[0].size(); ++i) {
    const double patch = patches[i % patches.size()];
    const bool mid_gray = patch == 0.18 || patch == 0.5;
    double mean = 0.0;
    for (const std::vector<PatchError>& errors : sessions) {
      const double error = errors[i].error;
      mean += error / static_cast<double>(sessions.size());
      rig.error_once = std::max(rig.error_once, std::abs(error));
      if (mid_gray) rig.error_mid_gray_once = std::max(rig.error_mid_gray_once, std::abs(error));
      rig.chi2_once += std::pow(error / errors[i].sigma, 2) / all;
    }
    rig.bias = std::max(rig.bias, std::abs(mean));
    if (mid_gray) rig.bias_mid_gray = std::max(rig.bias_mid_gray, std::abs(mean));
  }
}

void JudgeAlignment(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                    CalibrationStudyRig& rig) {
  std::vector<double> square(result.bands.size(), 0.0);
  double common = 0.0;
  const double px_per_mm = result.stack.valid.width() / session.rig.window_mm;
  const Point2 bulge = MeanBulge_mm(bench, session, result);
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
    const Point2 off{mean.x + Hill(unit) * bulge.x * px_per_mm, mean.y + Hill(unit) * bulge.y * px_per_mm};
    common += (off.x * off.x + off.y * off.y) / (kGrid * kGrid);
    for (std::size_t b = 0; b < errors.size(); ++b) {
      square[b] += (std::pow(errors[b].x - mean.x, 2) + std::pow(errors[b].y - mean.y, 2)) / (kGrid * kGrid);
    }
  }
  rig.alignment_error_px = std::sqrt(*std::max_element(square.begin(), square.end()));
  rig.window_error_px = std::sqrt(common);
}

void JudgeSkin(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
               CalibrationStudyRig& rig) {
  constexpr double kDrawn =
      1.0 / 6.0;  // variance that the bench's own linear interpolation of the patch adds
  const std::vector<PlaneF> truth = bench.patch().Mean();
  const std::vector<Band>& bands = bench.patch().bands;
  const ReflectanceStack& stack = result.stack;
  const double px_per_mm = stack.valid.width() / session.rig.window_mm;
  const Point2 bulge = MeanBulge_mm(bench, session, result);
  std::size_t k = 0;
  for (const BandCalibration& band : result.bands) {
    rig.dropped_bands += band.dropped ? 1 : 0;
    if (band.dropped) continue;
    std::size_t t = 0;
    while (bands[t].wavelength_nm != band.band.wavelength_nm) ++t;
    const double share = 1.0 / static_cast<double>(stack.bands.size());
    const PlaneF seen = Averaged(
        truth[t], {band.blur_px.x * band.blur_px.x + kDrawn, band.blur_px.y * band.blur_px.y + kDrawn},
        {bulge.x * px_per_mm, bulge.y * px_per_mm});
    rig.chi2_per_dof += share * Chi2(stack, k, seen);
    rig.chi2_sharp += share * Chi2(stack, k, truth[t]);
    ++k;
  }
}

}  // namespace dermap
