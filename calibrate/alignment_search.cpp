// SPDX-License-Identifier: Apache-2.0
// Gauss-Newton on a smooth warp (Lucas and Kanade, with the gain left free as Evangelidis and Psarakis do,
// PAMI 2008), robust against hairs and specks. Written out because OpenCV's findTransformECC knows neither
// bulges, nor priors, nor how sure its answer is.
#include "calibrate/alignment_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "calibrate/alignment_structure.h"
#include "calibrate/statistics.h"

namespace dermap {
namespace {

constexpr int kIterations = 12;  // of one search
constexpr int kStride = 2;       // pixels between samples: smoothed noise is wider than that
constexpr double kRobust = 4.0;  // sigmas at which a sample's weight is a quarter

float Between(const PlaneF& m, double x, double y) {
  const int ix = std::clamp(static_cast<int>(std::floor(x)), 0, m.width() - 2);
  const int iy = std::clamp(static_cast<int>(std::floor(y)), 0, m.height() - 2);
  const auto fx = static_cast<float>(x - ix);
  const auto fy = static_cast<float>(y - iy);
  const float* a = m.Row(iy) + ix;
  const float* b = m.Row(iy + 1) + ix;
  return (1 - fy) * ((1 - fx) * a[0] + fx * a[1]) + fy * ((1 - fx) * b[0] + fx * b[1]);
}

struct Row {
  float slope_x, slope_y, value, reference;
  std::array<double, Warp::kModes> modes;
};

std::vector<Row> RowsOf(const WarpProblem& problem, const Warp& warp) {
  std::vector<Row> rows;
  for (int y = 0; y < problem.mask.height(); y += kStride) {
    for (int x = 0; x < problem.mask.width(); x += kStride) {
      if (problem.mask(x, y) == 0) continue;
      const Point unit = UnitOf(x, y, problem.band);
      const auto modes = Warp::Modes(unit);
      const Point d = warp.Of(modes);
      const double px = x + d.x;
      const double py = y + d.y;
      if (px < 0 || py < 0 || px > problem.mask.width() - 1 || py > problem.mask.height() - 1) continue;
      // Slopes of the reference, the mean of many bands, have less noise than the band's own.
      rows.push_back({problem.reference.dx(x, y), problem.reference.dy(x, y), Between(problem.band, px, py),
                      problem.reference.value(x, y), modes});
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
WarpFit Step(const WarpProblem& problem, Warp& warp) {
  const std::vector<Row> rows = RowsOf(problem, warp);
  WarpFit fit;
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
    const auto& m = rows[k].modes;
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
  const double alike = std::max(
      1.0, 4.0 * std::numbers::pi * (problem.smooth_px * problem.smooth_px + 0.5) / (kStride * kStride));
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

}  // namespace

SlopedPicture::SlopedPicture(PlaneF picture)
    : value(std::move(picture)), dx(value.width(), value.height()), dy(value.width(), value.height()) {
  const auto view = [](PlaneF& plane) {
    return cv::Mat(plane.height(), plane.width(), CV_32F, plane.data());
  };
  cv::Mat slope_x = view(dx), slope_y = view(dy);
  cv::Sobel(view(value), slope_x, CV_32F, 1, 0, 3, 1.0 / 8.0);
  cv::Sobel(view(value), slope_y, CV_32F, 0, 1, 3, 1.0 / 8.0);
}

WarpFit SearchWarp(const WarpProblem& problem, Warp& warp) {
  WarpFit fit;
  for (int i = 0; i < kIterations; ++i) {
    fit = Step(problem, warp);
    if (fit.step_px < 0.1 * kSettledWarp_px) break;
  }
  return fit;
}

}  // namespace dermap
