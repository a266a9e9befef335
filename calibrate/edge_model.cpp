// SPDX-License-Identifier: Apache-2.0
// Projected Gauss-Newton on the edge model, photosites weighted by their light and, robustly, by their residuals.
#include "calibrate/edge_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calibrate/statistics.h"

namespace dermap {
namespace {

constexpr double kOutside_px = 7.0;
constexpr double kInsideShare = 1.0 / 18.0;  // of the window's depth: 0.4 mm of 7.5
constexpr double kLeastInside_px = 8.0;
constexpr double kSegment_px = 24.0;  // along, with levels of its own
// Ranges of scattering as shares of the window's depth: 0.05, 0.15, 0.45 and 1.35 mm of 7.5.
constexpr std::array<double, 4> kRanges{1.0 / 150, 1.0 / 50, 3.0 / 50, 9.0 / 50};
constexpr double kExpectedBlur_px = 0.65;
constexpr double kBlurScatter_px = 0.3;
constexpr double kLeastBlur_px = 0.3;  // a photosite's area alone: 1 / sqrt(12)
constexpr double kMostBlur_px = 3.0;
constexpr double kShareScatter = 0.5;  // what is expected of q: 0.2 each, give or take this
constexpr double kSlopeScatter = 0.3;  // of skin over the reach of the fit, relative
constexpr int kIterations = 15;
constexpr double kSettled_px = 0.002;
constexpr double kHuber = 2.5;         // robust sigmas
constexpr double kReadNoiseDn = 20.0;  // signal at which shot noise equals read noise, about
constexpr double kFarthest_px = 3.0;   // shift from where the edge was thought to be

// Unknowns: first those of the whole edge, then of each segment.
enum Shared { kFrom, kTo, kBlur, kShare0, kSharedCount = kShare0 + 4 };  // the fifth share is what is left of 1
enum Local { kTape, kLevel, kAlong, kAcross, kLocalCount };
constexpr int kGradient = kSharedCount + kLocalCount;
using Gradient = std::array<double, kGradient>;

struct Sample {
  double s, t;   // inwards of and along the edge as it was thought to be
  double value;  // reflectance
  double weight;
  int segment;
  double u;  // along within the segment, -1 ... 1
};

struct Model {
  double length, inside_px;
  std::array<double, 4> ranges_px;
  std::array<double, kSharedCount> shared{0.0, 0.0, kExpectedBlur_px, 0.2, 0.2, 0.2, 0.2};
  std::vector<std::array<double, kLocalCount>> local;
};

std::vector<Sample> Collect(const Mosaic& mosaic, const Edge& edge, double inside_px, int segments) {
  std::vector<Sample> samples;
  const double length = edge.length();
  const double first = kCornerShare * length;
  const double last = (1.0 - kCornerShare) * length;
  const Point along = edge.along();
  const double reach = std::max(inside_px, kOutside_px);
  const auto low = [&](double a, double b) { return static_cast<int>(std::floor(std::min(a, b) - reach)); };
  const auto high = [&](double a, double b) { return static_cast<int>(std::ceil(std::max(a, b) + reach)); };
  const int x0 = std::max(0, low(edge.from.x, edge.to.x) - mosaic.x0);
  const int x1 = std::min(mosaic.width(), high(edge.from.x, edge.to.x) - mosaic.x0);
  const int y0 = std::max(0, low(edge.from.y, edge.to.y) - mosaic.y0);
  const int y1 = std::min(mosaic.height(), high(edge.from.y, edge.to.y) - mosaic.y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const double dx = mosaic.x0 + x + 0.5 - edge.from.x;
      const double dy = mosaic.y0 + y + 0.5 - edge.from.y;
      const double t = dx * along.x + dy * along.y;
      const double s = dy * along.x - dx * along.y;
      const double white = mosaic.spectralon(x, y);
      if (s < -kOutside_px || s > inside_px || t < first || t >= last) continue;
      if (mosaic.mask(x, y) != 0 || white <= kReadNoiseDn / 4) continue;
      const double place = (t - first) / (last - first) * segments;
      const int segment = std::min(segments - 1, static_cast<int>(place));
      // Shot noise: variance of skin / white goes as 1 / white, beneath the read noise as 1 / white^2.
      const double weight = white * white / (white + kReadNoiseDn);
      samples.push_back({s, t, mosaic.scale * mosaic.skin(x, y) / white, weight, segment, 2 * (place - segment) - 1});
    }
  }
  return samples;
}

// Value of the model and its derivatives by the shared unknowns and those of the sample's segment.
double Evaluate(const Model& m, const Sample& p, Gradient& g) {
  const auto& [tape, level, slope_along, slope_across] = m.local[static_cast<std::size_t>(p.segment)];
  const double blur = m.shared[kBlur];
  const double share = p.t / m.length;
  const double d = p.s - (m.shared[kFrom] * (1 - share) + m.shared[kTo] * share);
  const double z = d / blur;
  if (z < -5.0) {
    g.fill(0.0);
    g[kSharedCount + kTape] = 1.0;
    return tape;
  }
  const double lit = 0.5 * std::erfc(-z / std::sqrt(2.0));  // share of the blur's light that comes from inside
  const double bell = 0.3989422804014327 * std::exp(-0.5 * z * z);
  // Mean depth from which that light comes: a function that is linear there is blurred exactly.
  const double depth = blur * (z + bell / lit);
  std::array<double, 5> e{1.0, 0, 0, 0, 0};
  double by_depth = 0.0;
  double left = 1.0;
  double sum = 1.0;
  std::array<double, 5> q{};
  for (int i = 0; i < 4; ++i) left -= q[i] = m.shared[kShare0 + i];
  q[4] = left;
  for (int i = 0; i < 4; ++i) {
    const double x = depth / m.ranges_px[i];
    e[i + 1] = std::erf(x);
    by_depth += q[i + 1] * 1.1283791670955126 * std::exp(-x * x) / m.ranges_px[i];
  }
  for (int i = 0; i < 5; ++i) sum += q[i] * e[i];
  const double shape = 0.5 * sum;
  const double skin = level * (1.0 + slope_along * p.u + slope_across * depth / m.inside_px);
  // Derivative of lit by d is bell / blur; that of depth by d lies between 0 and 1.
  const double ratio = bell / lit;
  const double depth_by_d = std::clamp(1.0 - ratio * (z + ratio), 0.0, 1.0);
  const double by_d = (skin * shape - tape) * bell / blur +
                      lit * depth_by_d * (0.5 * by_depth * skin + level * slope_across / m.inside_px * shape);
  g[kFrom] = -by_d * (1 - share);
  g[kTo] = -by_d * share;
  g[kBlur] = -z * (skin * shape - tape) * bell / blur;
  for (int i = 0; i < 4; ++i) g[kShare0 + i] = 0.5 * lit * skin * (e[i] - e[4]);
  g[kSharedCount + kTape] = 1.0 - lit;
  g[kSharedCount + kLevel] = lit * shape * skin / level;
  g[kSharedCount + kAlong] = lit * shape * level * p.u;
  g[kSharedCount + kAcross] = lit * shape * level * depth / m.inside_px;
  return tape * (1.0 - lit) + lit * skin * shape;
}

// Levels from the samples that lie clear of the edge.
bool StartLevels(const std::vector<Sample>& samples, int segments, Model& model) {
  std::vector<std::array<double, 4>> sums(static_cast<std::size_t>(segments), {0, 0, 0, 0});
  for (const Sample& p : samples) {
    auto& s = sums[static_cast<std::size_t>(p.segment)];
    if (p.s < -2.0) s[0] += p.weight * p.value, s[1] += p.weight;
    if (p.s > 0.5 * model.inside_px) s[2] += p.weight * p.value, s[3] += p.weight;
  }
  for (const auto& s : sums) {
    if (!(s[1] > 0.0) || !(s[3] > 0.0) || !(s[2] > 0.0)) return false;
    model.local.push_back({s[0] / s[1], 1.2 * s[2] / s[3], 0.0, 0.0});
  }
  return true;
}

struct Normal {
  Eigen::MatrixXd matrix;  // lower triangle
  Eigen::VectorXd right;
  double sigma = 0.0;  // robust standard deviation of a weighted residual
};

Eigen::Index IndexOf(int i, int segment) {
  return i < kSharedCount ? i : kSharedCount + kLocalCount * segment + (i - kSharedCount);
}

void AddExpectation(Normal& normal, Eigen::Index index, double value, double expected, double scatter) {
  const double weight = normal.sigma * normal.sigma / (scatter * scatter);
  normal.matrix(index, index) += weight;
  normal.right(index) += weight * (expected - value);
}

Normal Linearise(const std::vector<Sample>& samples, const Model& model) {
  const auto unknowns = static_cast<Eigen::Index>(kSharedCount + kLocalCount * model.local.size());
  std::vector<Gradient> gradients(samples.size());
  std::vector<float> residuals(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double difference = samples[k].value - Evaluate(model, samples[k], gradients[k]);
    residuals[k] = static_cast<float>(std::sqrt(samples[k].weight) * difference);
  }
  Normal normal{Eigen::MatrixXd::Zero(unknowns, unknowns), Eigen::VectorXd::Zero(unknowns), 0.0};
  normal.sigma = std::max(1e-9, MedianAndScatter(residuals).sigma);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double size = std::abs(static_cast<double>(residuals[k]));
    const double robust = size > kHuber * normal.sigma ? kHuber * normal.sigma / size : 1.0;
    const double root = std::sqrt(samples[k].weight);
    for (int i = 0; i < kGradient; ++i) {
      const double gi = robust * root * gradients[k][i];
      normal.right(IndexOf(i, samples[k].segment)) += gi * residuals[k];
      for (int j = 0; j <= i; ++j) {
        normal.matrix(IndexOf(i, samples[k].segment), IndexOf(j, samples[k].segment)) += gi * root * gradients[k][j];
      }
    }
  }
  AddExpectation(normal, kBlur, model.shared[kBlur], kExpectedBlur_px, kBlurScatter_px);
  for (int i = 0; i < 4; ++i) AddExpectation(normal, kShare0 + i, model.shared[kShare0 + i], 0.2, kShareScatter);
  for (std::size_t i = 0; i < model.local.size(); ++i) {
    AddExpectation(normal, IndexOf(kSharedCount + kAcross, static_cast<int>(i)), model.local[i][kAcross], 0.0,
                   kSlopeScatter);
  }
  normal.matrix.diagonal().array() *= 1.0 + 1e-6;
  return normal;
}

// Shares that are 0 and would become negative stay where they are.
void Freeze(const Model& model, Normal& normal) {
  for (int i = kShare0; i < kSharedCount; ++i) {
    if (model.shared[i] > 0.0 || normal.right(i) >= 0.0) continue;
    normal.matrix.row(i).setZero();
    normal.matrix.col(i).setZero();
    normal.matrix(i, i) = 1.0;
    normal.right(i) = 0.0;
  }
}

// Returns how far the edge moved.
double Step(const Normal& normal, Model& model) {
  const Eigen::VectorXd step = normal.matrix.selfadjointView<Eigen::Lower>().ldlt().solve(normal.right);
  auto& shared = model.shared;
  shared[kFrom] += std::clamp(step(kFrom), -0.7, 0.7);
  shared[kTo] += std::clamp(step(kTo), -0.7, 0.7);
  shared[kBlur] = std::clamp(shared[kBlur] + std::clamp(step(kBlur), -0.2, 0.2), kLeastBlur_px, kMostBlur_px);
  double sum = 0.0;
  for (int i = kShare0; i < kSharedCount; ++i) {
    shared[i] = std::clamp(shared[i] + std::clamp(step(i), -0.3, 0.3), 0.0, 1.0);
    sum += shared[i];
  }
  for (int i = kShare0; i < kSharedCount; ++i) shared[i] /= std::max(1.0, sum);
  for (std::size_t k = 0; k < model.local.size(); ++k) {
    auto& local = model.local[k];
    for (int j = 0; j < kLocalCount; ++j) local[j] += step(IndexOf(kSharedCount + j, static_cast<int>(k)));
    local[kLevel] = std::max(local[kLevel], 1e-4);
  }
  return std::max(std::abs(step(kFrom)), std::abs(step(kTo)));
}

}  // namespace

double Edge::length() const { return std::hypot(to.x - from.x, to.y - from.y); }
Point Edge::along() const { return {(to.x - from.x) / length(), (to.y - from.y) / length()}; }
Point Edge::inwards() const { return {-along().y, along().x}; }
Point Edge::At(double t, double s) const {
  const Point a = along();
  return {from.x + t * a.x - s * a.y, from.y + t * a.y + s * a.x};
}

std::optional<EdgeShift> FitEdgeModel(const Mosaic& mosaic, const Edge& edge) {
  Model model;
  model.length = edge.length();
  model.inside_px = std::max(kLeastInside_px, kInsideShare * edge.depth_px);
  for (int i = 0; i < 4; ++i) model.ranges_px[i] = kRanges[i] * edge.depth_px;
  const int segments = std::max(1, static_cast<int>((1.0 - 2.0 * kCornerShare) * model.length / kSegment_px));
  const std::vector<Sample> samples = Collect(mosaic, edge, model.inside_px, segments);
  if (samples.size() < static_cast<std::size_t>(50 * segments) || !StartLevels(samples, segments, model)) {
    return std::nullopt;
  }
  Normal normal;
  for (int i = 0; i < kIterations; ++i) {
    normal = Linearise(samples, model);
    Freeze(model, normal);
    if (Step(normal, model) < kSettled_px && i > 3) break;
  }
  const auto& shared = model.shared;
  const double farthest = std::max(std::abs(shared[kFrom]), std::abs(shared[kTo]));
  if (!std::isfinite(shared[kFrom] + shared[kTo]) || farthest > kFarthest_px) return std::nullopt;
  Eigen::VectorXd middle = Eigen::VectorXd::Zero(normal.matrix.rows());
  middle(kFrom) = middle(kTo) = 0.5;
  const double variance = middle.dot(normal.matrix.selfadjointView<Eigen::Lower>().ldlt().solve(middle));
  return EdgeShift{shared[kFrom], shared[kTo], shared[kBlur], normal.sigma * std::sqrt(std::max(0.0, variance))};
}

}  // namespace dermap
