// SPDX-License-Identifier: Apache-2.0
// Each band against the mean of all others: Gauss-Newton on a smooth warp (Lucas and Kanade, with the gain
// left free as Evangelidis and Psarakis do, PAMI 2008), from coarse to fine, robust against hairs and specks.
// Written out because OpenCV's findTransformECC knows neither bulges, nor priors, nor how sure its answer is.
#include "calibrate/alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/statistics.h"
#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr double kSmooth_px = 1.0;  // against noise
constexpr int kTapeBlur_px =
    6;  // along the border: darkened by the tape's edge, kept out of the smoothing too
// What is smoother than this (0.23 mm) is light and shape, not structure: light spreads as far as that, in
// each band by another length, and a freckle's halo then seems to lie elsewhere.
constexpr double kCoarse_px = 8.0;
constexpr double kDarkest = 0.003;
constexpr int kPasses = 4;                // the mean of the others becomes sharper as they move into place
constexpr int kIterations = 12;           // of one search
constexpr double kCoarseSmooth_px = 3.0;  // of the first search, which catches shifts of several pixels
constexpr double kSettled_px = 0.01;      // a pass that moves no band farther is the last
constexpr int kStride = 2;                // pixels between samples: smoothed noise is wider than that
constexpr double kRobust = 4.0;           // sigmas at which a sample's weight is a quarter
constexpr double kPi = 3.14159265358979323846;
// What is expected of the modes, one standard deviation, pixels: shift, strain and rotation, bulges. The
// window has been followed already; on skin without much structure more freedom would only follow noise.
constexpr std::array<double, Warp::kModes> kPrior_px{0.5, 0.15, 0.15, 0.3, 0.15, 0.15};
constexpr int kAffineModes = 3;
constexpr double kSkinAtTape_px = 0.03;  // what the tape lets skin move at its border, one standard deviation
using Prior = std::array<double, Warp::kModes>;

Prior PriorOf(double window_sigma_px) {
  Prior prior = kPrior_px;
  for (int i = 0; i < kAffineModes; ++i)
    prior[i] = std::min(prior[i], std::hypot(window_sigma_px, kSkinAtTape_px));
  return prior;
}

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

// A picture and its slopes, read between pixels.
struct Sampled {
  cv::Mat value, dx, dy;
  explicit Sampled(const cv::Mat& picture) : value(picture) {
    cv::Sobel(picture, dx, CV_32F, 1, 0, 3, 1.0 / 8.0);
    cv::Sobel(picture, dy, CV_32F, 0, 1, 3, 1.0 / 8.0);
  }
};

float Between(const cv::Mat& m, double x, double y) {
  const int ix = std::clamp(static_cast<int>(std::floor(x)), 0, m.cols - 2);
  const int iy = std::clamp(static_cast<int>(std::floor(y)), 0, m.rows - 2);
  const auto fx = static_cast<float>(x - ix);
  const auto fy = static_cast<float>(y - iy);
  const float* a = m.ptr<float>(iy) + ix;
  const float* b = m.ptr<float>(iy + 1) + ix;
  return (1 - fy) * ((1 - fx) * a[0] + fx * a[1]) + fy * ((1 - fx) * b[0] + fx * b[1]);
}

Point UnitOf(int x, int y, const cv::Mat& m) {
  return {(x + 0.5) / m.cols, (y + 0.5) / m.rows};
}

cv::Mat Moved(const cv::Mat& picture, const Warp& warp) {
  cv::Mat map_x(picture.size(), CV_32F);
  cv::Mat map_y(picture.size(), CV_32F);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const Point d = warp.At(UnitOf(x, y, picture));
      map_x.at<float>(y, x) = static_cast<float>(x + d.x);
      map_y.at<float>(y, x) = static_cast<float>(y + d.y);
    }
  }
  cv::Mat out;
  cv::remap(picture, out, map_x, map_y, cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return out;
}

// Mean of some structures, moved into place, weighted by how much of each is not noise.
cv::Mat MeanOfOthers(const std::vector<Structure>& structures, const std::vector<cv::Mat>& moved,
                     std::size_t self) {
  cv::Mat sum(structures[self].picture.size(), CV_32F, cv::Scalar(0));
  double total = 0.0;
  for (std::size_t i = 0; i < structures.size(); ++i) {
    if (i == self || structures[i].weight <= 0.0) continue;
    sum += structures[i].weight * moved[i];
    total += structures[i].weight;
  }
  return total > 0.0 ? cv::Mat(sum / total) : cv::Mat();
}

struct Problem {
  Sampled reference;
  cv::Mat band;
  const cv::Mat& mask;
  double smooth_px;  // of both, for the number of samples that are independent
  int modes;         // used, of each direction
  Prior prior_px;
};

struct Fit {
  double correlation = 0.0;
  double uncertainty_px = 0.0;
  double step_px = 0.0;
};

struct Row {
  float slope_x, slope_y, value, reference;
  Point unit;
};

std::vector<Row> RowsOf(const Problem& problem, const Warp& warp) {
  std::vector<Row> rows;
  for (int y = 0; y < problem.mask.rows; y += kStride) {
    for (int x = 0; x < problem.mask.cols; x += kStride) {
      if (problem.mask.at<std::uint8_t>(y, x) == 0) continue;
      const Point unit = UnitOf(x, y, problem.mask);
      const Point d = warp.At(unit);
      const double px = x + d.x;
      const double py = y + d.y;
      if (px < 0 || py < 0 || px > problem.mask.cols - 1 || py > problem.mask.rows - 1) continue;
      // Slopes of the reference, the mean of many bands, have less noise than the band's own.
      rows.push_back({problem.reference.dx.at<float>(y, x), problem.reference.dy.at<float>(y, x),
                      Between(problem.band, px, py), problem.reference.value.at<float>(y, x), unit});
    }
  }
  return rows;
}

struct Gain {
  double a = 0.0, b = 0.0, correlation = 0.0;  // reference = a value + b
};

Gain GainOf(const std::vector<Row>& rows) {
  double n = 0, sv = 0, sr = 0, vv = 0, vr = 0, rr = 0;
  for (const Row& r : rows) {
    n += 1, sv += r.value, sr += r.reference;
    vv += double(r.value) * r.value, vr += double(r.value) * r.reference,
        rr += double(r.reference) * r.reference;
  }
  const double cvv = vv - sv * sv / n;
  const double cvr = vr - sv * sr / n;
  const double crr = rr - sr * sr / n;
  if (!(cvv > 0.0) || !(crr > 0.0)) return {};
  return {cvr / cvv, (sr - cvr / cvv * sv) / n, cvr / std::sqrt(cvv * crr)};
}

// One step of Gauss and Newton; the warp moves.
Fit Step(const Problem& problem, Warp& warp) {
  const std::vector<Row> rows = RowsOf(problem, warp);
  Fit fit;
  if (rows.size() < 100) return fit;
  const Gain gain = GainOf(rows);
  fit.correlation = gain.correlation;
  std::vector<float> residuals;
  for (const Row& r : rows) residuals.push_back(static_cast<float>(r.reference - gain.a * r.value - gain.b));
  const double sigma = std::max(1e-6, MedianAndScatter(residuals).sigma);
  const int modes = problem.modes;
  const int unknowns = 2 * modes;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  std::array<double, 2 * Warp::kModes> g{};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto m = Warp::Modes(rows[k].unit);
    for (int i = 0; i < modes; ++i) {
      g[i] = rows[k].slope_x * m[i];
      g[modes + i] = rows[k].slope_y * m[i];
    }
    const double q = residuals[k] / (kRobust * sigma);
    const double weight = 1.0 / ((1.0 + q * q) * (1.0 + q * q));
    for (int i = 0; i < unknowns; ++i) {
      right(i) += weight * g[i] * residuals[k];
      for (int j = 0; j <= i; ++j) normal(i, j) += weight * g[i] * g[j];
    }
  }
  // Neighbours within the smoothing's width count as one sample.
  const double alike =
      std::max(1.0, 4.0 * kPi * (problem.smooth_px * problem.smooth_px + 0.5) / (kStride * kStride));
  const double variance = sigma * sigma * alike;
  normal /= variance;
  right /= variance;
  for (int i = 0; i < unknowns; ++i) {
    const int mode = i % modes;
    const double pull = 1.0 / (problem.prior_px[mode] * problem.prior_px[mode]);
    normal(i, i) += pull;
    right(i) -= pull * warp.p[i < modes ? mode : Warp::kModes + mode];
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal.selfadjointView<Eigen::Lower>());
  const Eigen::VectorXd step = solver.solve(right);
  for (int i = 0; i < unknowns; ++i) {
    warp.p[i < modes ? i : Warp::kModes + (i - modes)] += std::clamp(step(i), -2.0, 2.0);
    fit.step_px = std::max(fit.step_px, std::abs(step(i)));
  }
  const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(unknowns, unknowns));
  fit.uncertainty_px = std::sqrt(std::max(covariance(0, 0), covariance(modes, modes)));
  return fit;
}

Fit Search(const Problem& problem, Warp& warp) {
  Fit fit;
  for (int i = 0; i < kIterations; ++i) {
    fit = Step(problem, warp);
    if (fit.step_px < 0.1 * kSettled_px) break;
  }
  return fit;
}

// All bands move at once, each towards the mean of the others, so each goes only its share of the way: else
// they would pass one another (two bands would swap places for ever).
void Damp(const Warp& before, double share, Warp& warp) {
  for (std::size_t i = 0; i < warp.p.size(); ++i) warp.p[i] = before.p[i] + share * (warp.p[i] - before.p[i]);
}

// What the warp is in words.
void Describe(int width_px, BandAlignment& a) {
  const auto& p = a.warp.p;
  const Point middle = a.warp.At({0.5, 0.5});
  a.dx_px = middle.x;
  a.dy_px = middle.y;
  const double turn = 0.5 * (p[Warp::kModes + 1] - p[2]);  // pixels at the border
  a.angle_rad = turn / (0.5 * width_px);
  a.stretch_px = 0.0;
  for (int y = 0; y <= 8; ++y) {
    for (int x = 0; x <= 8; ++x) {
      const Point unit{x / 8.0, y / 8.0};
      const Point d = a.warp.At(unit);
      const double sx = d.x - p[0] + turn * (2 * unit.y - 1);
      const double sy = d.y - p[Warp::kModes] - turn * (2 * unit.x - 1);
      a.stretch_px = std::max(a.stretch_px, std::hypot(sx, sy));
    }
  }
}

void Judge(const AlignmentOptions& options, int width_px, BandAlignment& a) {
  Describe(width_px, a);
  const double shift = a.found_shift_px = std::hypot(a.dx_px, a.dy_px);
  if (!(a.correlation >= options.smallest_correlation) ||
      !(a.uncertainty_px <= options.largest_uncertainty_px)) {
    a.note = "shares too little structure with the other bands (correlation " + Short(a.correlation) +
             ", shift known to " + Short(a.uncertainty_px) + " px): the window's own alignment is kept";
  } else if (shift > options.largest_shift_px) {
    a.clearly_off = true;
    a.note = "lies " + Short(shift) + " px off the other bands inside the window";
  } else {
    a.applied = true;
  }
  if (!a.applied) {
    a.warp = {};
    Describe(width_px, a);
  }
}

// The bands' windows are, on average, where the patch is: alignment must not move the whole stack.
void RemoveMean(int width_px, std::vector<BandAlignment>& bands) {
  Warp mean;
  const auto count = std::count_if(bands.begin(), bands.end(), [](const auto& a) { return a.applied; });
  for (const auto& a : bands) {
    for (std::size_t i = 0; a.applied && i < mean.p.size(); ++i) mean.p[i] += a.warp.p[i] / double(count);
  }
  for (auto& a : bands) {
    if (!a.applied) continue;
    for (std::size_t i = 0; i < mean.p.size(); ++i) a.warp.p[i] -= mean.p[i];
    Describe(width_px, a);
  }
}

// One band against the mean of the others, from where all of them are now.
BandAlignment AlignBand(const Structure& own, const cv::Mat& reference, const BandAlignment& before,
                        const Prior& prior, bool first, double share, const AlignmentOptions& options) {
  BandAlignment found;
  if (own.weight <= 0.0 || reference.empty()) {
    found.note = "shows no structure above its noise: the window's own alignment is kept";
    return found;
  }
  found.warp = before.warp;
  if (first) {
    cv::Mat coarse, coarse_reference;
    cv::GaussianBlur(own.picture, coarse, {}, kCoarseSmooth_px);
    cv::GaussianBlur(reference, coarse_reference, {}, kCoarseSmooth_px);
    Search(
        {Sampled(coarse_reference), coarse, own.mask, std::hypot(kSmooth_px, kCoarseSmooth_px), 1, kPrior_px},
        found.warp);
  }
  Search({Sampled(reference), own.picture, own.mask, kSmooth_px, kAffineModes, prior}, found.warp);
  const Fit fit =
      Search({Sampled(reference), own.picture, own.mask, kSmooth_px, Warp::kModes, prior}, found.warp);
  found.correlation = fit.correlation;
  found.uncertainty_px = fit.uncertainty_px;
  Damp(before.warp, share, found.warp);
  Judge(options, own.mask.cols, found);
  return found;
}

PlaneF Residual(const Structure& own, const cv::Mat& moved, const cv::Mat& reference, double correlation) {
  PlaneF residual(moved.cols, moved.rows, std::nanf(""));
  if (reference.empty()) return residual;
  for (int y = 0; y < moved.rows; ++y) {
    for (int x = 0; x < moved.cols; ++x) {
      if (own.mask.at<std::uint8_t>(y, x) != 0)
        residual(x, y) = static_cast<float>(correlation) * moved.at<float>(y, x) - reference.at<float>(y, x);
    }
  }
  return residual;
}

}  // namespace

std::vector<BandAlignment> AlignBands(std::span<const PlaneF> reflectance, std::span<const PlaneF> noise,
                                      std::span<const double> window_sigma_px,
                                      const AlignmentOptions& options) {
  const auto count = static_cast<int>(reflectance.size());
  std::vector<Structure> structures(reflectance.size());
  ParallelFor(count,
              [&](int i) { structures[i] = StructureOf(reflectance[i], noise[i], options.border_px); });
  const auto sharing =
      std::count_if(structures.begin(), structures.end(), [](const auto& s) { return s.weight > 0.0; });
  const double share = sharing > 0 ? (double(sharing) - 1.0) / double(sharing) : 0.0;
  const int width = reflectance.empty() ? 0 : reflectance[0].width();
  std::vector<BandAlignment> bands(reflectance.size());
  std::vector<cv::Mat> moved(reflectance.size());
  const auto move_all = [&] {
    ParallelFor(count, [&](int i) { moved[i] = Moved(structures[i].picture, bands[i].warp); });
  };
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<BandAlignment> next = bands;
    move_all();
    ParallelFor(count, [&](int i) {
      if (pass > 0 && !bands[i].applied) return;
      const cv::Mat reference = MeanOfOthers(structures, moved, static_cast<std::size_t>(i));
      const Prior prior = window_sigma_px.empty() ? kPrior_px : PriorOf(window_sigma_px[i]);
      next[i] = AlignBand(structures[i], reference, bands[i], prior, pass == 0, share, options);
    });
    RemoveMean(width, next);
    double settled = 0.0;
    for (int i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < next[i].warp.p.size(); ++k)
        settled = std::max(settled, std::abs(next[i].warp.p[k] - bands[i].warp.p[k]));
    }
    bands = std::move(next);
    if (settled < kSettled_px) break;
  }
  move_all();
  ParallelFor(count, [&](int i) {
    const cv::Mat reference = MeanOfOthers(structures, moved, static_cast<std::size_t>(i));
    bands[i].residual = Residual(structures[i], moved[i], reference, bands[i].correlation);
  });
  return bands;
}

}  // namespace dermap
