// SPDX-License-Identifier: Apache-2.0
// Each band against the mean of all others, by maximising the enhanced correlation coefficient (Evangelidis
// and Psarakis, PAMI 2008; OpenCV's findTransformECC), from coarse to fine.
#include "calibrate/alignment.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "calibrate/statistics.h"
#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr double kSmooth_px = 1.0;  // against noise
constexpr int kTapeBlur_px =
    6;  // along the border: darkened by the tape's edge, kept out of the smoothing too
constexpr double kCoarse_px = 10.0;  // what is smoother than this is light and shape, not structure
constexpr double kDarkest = 0.003;
constexpr int kPasses = 3;            // the mean of the others becomes sharper as they move into place
constexpr int kIterations = 30;       // of one search
constexpr double kSettled_px = 0.01;  // a pass that moves no band farther is the last
constexpr double kPi = 3.14159265358979323846;

// Fine structure of a band in log reflectance, scaled to a standard deviation of 1 within the mask.
struct Structure {
  cv::Mat picture;      // CV_32F
  cv::Mat mask;         // CV_8U: inside the border and present
  double weight = 0.0;  // in the mean of the others: the share of its variance that is not noise
};

cv::Mat NormalisedBlur(const cv::Mat& values, const cv::Mat& weights, double sigma) {
  cv::Mat sum;
  cv::Mat norm;
  cv::GaussianBlur(values.mul(weights), sum, {}, sigma, sigma, cv::BORDER_REFLECT);
  cv::GaussianBlur(weights, norm, {}, sigma, sigma, cv::BORDER_REFLECT);
  return sum / (norm + 1e-6);
}

Structure StructureOf(const PlaneF& reflectance, const PlaneF& noise, int border) {
  Structure s;
  cv::Mat log_r(reflectance.height(), reflectance.width(), CV_32F, cv::Scalar(0));
  cv::Mat weights(log_r.size(), CV_32F, cv::Scalar(0));
  s.mask = cv::Mat(log_r.size(), CV_8U, cv::Scalar(0));
  std::vector<float> relative;
  for (int y = 0; y < log_r.rows; ++y) {
    for (int x = 0; x < log_r.cols; ++x) {
      const float r = reflectance(x, y);
      if (!std::isfinite(r)) continue;
      log_r.at<float>(y, x) = static_cast<float>(std::log(std::max(static_cast<double>(r), kDarkest)));
      const int edge = std::min({x, y, log_r.cols - 1 - x, log_r.rows - 1 - y});
      if (edge >= kTapeBlur_px) weights.at<float>(y, x) = 1.0f;
      if (edge < border) continue;
      s.mask.at<std::uint8_t>(y, x) = 255;
      if (std::isfinite(noise(x, y)) && r > 0.0f) relative.push_back(noise(x, y) / r);
    }
  }
  s.picture = NormalisedBlur(log_r, weights, kSmooth_px) - NormalisedBlur(log_r, weights, kCoarse_px);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(s.picture, mean, deviation, s.mask);
  if (!(deviation[0] > 0.0) || relative.empty()) return s;
  s.picture = (s.picture - mean[0]) / deviation[0];
  // Resampled noise is about 0.7 px wide (standard deviation) already; smoothing by 1 px leaves a third of
  // its variance.
  const double left = 0.5 / (0.5 + kSmooth_px * kSmooth_px);
  const double noise_variance = left * std::pow(Median(relative), 2);
  s.weight = std::max(0.0, 1.0 - noise_variance / (deviation[0] * deviation[0]));
  return s;
}

// Matrix of OpenCV's inverse map (band from aligned) about the origin, from a motion about the middle.
cv::Matx23f MatrixOf(const BandAlignment& a, cv::Size size) {
  const double c = std::cos(a.angle_rad);
  const double s = std::sin(a.angle_rad);
  const double mx = (size.width - 1) / 2.0;
  const double my = (size.height - 1) / 2.0;
  return {float(c), float(-s), float(mx - c * mx + s * my + a.dx_px),
          float(s), float(c),  float(my - s * mx - c * my + a.dy_px)};
}

void SetMotion(const cv::Matx23f& m, cv::Size size, BandAlignment& a) {
  const double mx = (size.width - 1) / 2.0;
  const double my = (size.height - 1) / 2.0;
  a.angle_rad = std::atan2(m(1, 0), m(0, 0));
  a.dx_px = m(0, 0) * mx + m(0, 1) * my + m(0, 2) - mx;
  a.dy_px = m(1, 0) * mx + m(1, 1) * my + m(1, 2) - my;
}

cv::Mat Moved(const cv::Mat& picture, const BandAlignment& a) {
  cv::Mat out;
  cv::warpAffine(picture, out, MatrixOf(a, picture.size()), picture.size(),
                 cv::INTER_CUBIC | cv::WARP_INVERSE_MAP, cv::BORDER_REFLECT);
  return out;
}

// Weighted mean of all structures but one, moved into place.
cv::Mat MeanOfOthers(const std::vector<Structure>& structures, const std::vector<BandAlignment>& now,
                     std::size_t self) {
  cv::Mat sum(structures[self].picture.size(), CV_32F, cv::Scalar(0));
  double total = 0.0;
  for (std::size_t i = 0; i < structures.size(); ++i) {
    if (i == self || structures[i].weight <= 0.0) continue;
    sum += structures[i].weight * Moved(structures[i].picture, now[i]);
    total += structures[i].weight;
  }
  return total > 0.0 ? cv::Mat(sum / total) : cv::Mat();
}

// False where the search fails or wanders off. A first search begins at half the size.
bool Search(const cv::Mat& reference, const Structure& band, bool first, BandAlignment& a) {
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations, 1e-5);
  try {
    for (int reduction = first ? 2 : 1; reduction >= 1; --reduction) {
      cv::Mat small_reference = reference;
      cv::Mat small_band = band.picture;
      cv::Mat small_mask = band.mask;
      if (reduction > 1) {
        cv::resize(reference, small_reference, {}, 0.5, 0.5, cv::INTER_AREA);
        cv::resize(band.picture, small_band, {}, 0.5, 0.5, cv::INTER_AREA);
        cv::resize(band.mask, small_mask, {}, 0.5, 0.5, cv::INTER_NEAREST);
      }
      BandAlignment scaled = a;
      scaled.dx_px /= reduction, scaled.dy_px /= reduction;
      cv::Mat matrix(MatrixOf(scaled, small_band.size()));
      a.correlation = cv::findTransformECC(small_reference, small_band, matrix, cv::MOTION_EUCLIDEAN, stop,
                                           small_mask, 1);
      SetMotion(cv::Matx23f(matrix.ptr<float>()), small_band.size(), a);
      a.dx_px *= reduction, a.dy_px *= reduction;
    }
  } catch (const cv::Exception&) {
    return false;
  }
  return std::isfinite(a.dx_px) && std::isfinite(a.dy_px);
}

// Standard deviation of a shift found by correlation: residual noise of the variance (1 - rho^2) / rho^2
// against the mean squared slope of the structure; neighbours within the smoothing's width count as one.
double Uncertainty(const cv::Mat& reference, const cv::Mat& mask, double correlation) {
  cv::Mat gx;
  cv::Mat gy;
  cv::Sobel(reference, gx, CV_32F, 1, 0, 3, 1.0 / 8.0);
  cv::Sobel(reference, gy, CV_32F, 0, 1, 3, 1.0 / 8.0);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(reference, mean, deviation, mask);
  const double slope = std::min(cv::norm(gx, cv::NORM_L2SQR, mask), cv::norm(gy, cv::NORM_L2SQR, mask)) /
                       std::max(1e-12, deviation[0] * deviation[0]);
  const double area = 4.0 * kPi * (kSmooth_px * kSmooth_px + 0.5);
  const double rho2 = std::max(1e-6, correlation * correlation);
  return std::sqrt(area * (1.0 - rho2) / rho2 / std::max(1e-12, slope));
}

// All bands move at once, each towards the mean of the others, so each goes only its share of the way: else
// they would pass one another (two bands would swap places for ever).
void Damp(const BandAlignment& before, double share, BandAlignment& a) {
  a.dx_px = before.dx_px + share * (a.dx_px - before.dx_px);
  a.dy_px = before.dy_px + share * (a.dy_px - before.dy_px);
  a.angle_rad = before.angle_rad + share * (a.angle_rad - before.angle_rad);
}

void Judge(const AlignmentOptions& options, BandAlignment& a) {
  const double shift = std::hypot(a.dx_px, a.dy_px);
  if (a.correlation < options.smallest_correlation || a.uncertainty_px > options.largest_uncertainty_px) {
    a.note = "shares too little structure with the other bands (correlation " + Short(a.correlation) +
             ", shift known to " + Short(a.uncertainty_px) + " px): the window's own alignment is kept";
  } else if (shift > options.largest_shift_px) {
    a.clearly_off = true;
    a.note = "lies " + Short(shift) + " px off the other bands inside the window";
  } else {
    a.applied = true;
  }
  if (!a.applied) a.dx_px = a.dy_px = a.angle_rad = 0.0;
}

// The bands' windows are, on average, where the patch is: alignment must not move the whole stack.
void RemoveMean(std::vector<BandAlignment>& bands) {
  double dx = 0, dy = 0, angle = 0;
  const auto count = std::count_if(bands.begin(), bands.end(), [](const auto& a) { return a.applied; });
  for (const auto& a : bands) {
    if (a.applied)
      dx += a.dx_px / double(count), dy += a.dy_px / double(count), angle += a.angle_rad / double(count);
  }
  for (auto& a : bands) {
    if (a.applied) a.dx_px -= dx, a.dy_px -= dy, a.angle_rad -= angle;
  }
}

// One band against the mean of the others, from where all of them are now.
BandAlignment AlignBand(const std::vector<Structure>& structures, const std::vector<BandAlignment>& now,
                        int self, bool first, double share, const AlignmentOptions& options) {
  const Structure& own = structures[static_cast<std::size_t>(self)];
  const BandAlignment& before = now[static_cast<std::size_t>(self)];
  BandAlignment none;
  const cv::Mat reference = MeanOfOthers(structures, now, static_cast<std::size_t>(self));
  if (own.weight <= 0.0 || reference.empty()) {
    none.note = "shows no structure above its noise: the window's own alignment is kept";
    return none;
  }
  BandAlignment found = before;
  if (!Search(reference, own, first, found)) {
    none.note = "alignment with the other bands did not converge: the window's own alignment is kept";
    return none;
  }
  found.note.clear();
  found.applied = found.clearly_off = false;
  found.uncertainty_px = Uncertainty(reference, own.mask, found.correlation);
  Damp(before, share, found);
  Judge(options, found);
  return found;
}

}  // namespace

std::vector<BandAlignment> AlignBands(std::span<const PlaneF> reflectance, std::span<const PlaneF> noise,
                                      const AlignmentOptions& options) {
  const auto count = static_cast<int>(reflectance.size());
  std::vector<Structure> structures(reflectance.size());
  ParallelFor(count,
              [&](int i) { structures[i] = StructureOf(reflectance[i], noise[i], options.border_px); });
  const auto sharing =
      std::count_if(structures.begin(), structures.end(), [](const auto& s) { return s.weight > 0.0; });
  const double share = sharing > 0 ? (double(sharing) - 1.0) / double(sharing) : 0.0;
  std::vector<BandAlignment> bands(reflectance.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<BandAlignment> next = bands;
    ParallelFor(count, [&](int i) {
      if (pass == 0 || bands[i].applied) next[i] = AlignBand(structures, bands, i, pass == 0, share, options);
    });
    RemoveMean(next);
    double moved = 0.0;
    for (int i = 0; i < count; ++i) {
      moved = std::max(moved, std::hypot(next[i].dx_px - bands[i].dx_px, next[i].dy_px - bands[i].dy_px));
    }
    bands = std::move(next);
    if (moved < kSettled_px) break;
  }
  return bands;
}

}  // namespace dermap
