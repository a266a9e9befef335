// SPDX-License-Identifier: Apache-2.0
// Gauss-Newton on the blurred-edge model, photosites weighted by their light and, robustly, by their
// residuals.
#include "calibrate/edge_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "calibrate/statistics.h"

namespace dermap {
namespace {

constexpr double kReach_px = 7.0;     // to either side
constexpr double kSegment_px = 24.0;  // along, with levels of its own
constexpr double kFirstBlur_px = 0.7;
constexpr double kLeastBlur_px = 0.3;  // a photosite's area alone: 1 / sqrt(12)
constexpr double kMostBlur_px = 3.0;
constexpr int kIterations = 8;
constexpr double kHuber = 2.5;         // robust sigmas
constexpr double kReadNoiseDn = 20.0;  // signal at which shot noise equals read noise, about
constexpr double kFarthest_px = 2.5;   // shift from where the edge was thought to be
constexpr double kPi = 3.14159265358979323846;

constexpr int kShared = 3;      // shift at from and to, blur
constexpr int kPerSegment = 4;  // outside, inside, its slopes across and along

struct Sample {
  double s, t;   // inwards of and along the edge as it was thought to be
  double value;  // reflectance
  double weight;
  int segment;
  double u;  // along within the segment, -1 ... 1
};

std::vector<Sample> Collect(const Mosaic& mosaic, const Edge& edge, int segments) {
  std::vector<Sample> samples;
  const double first = kCornerShare * edge.length();
  const double last = (1.0 - kCornerShare) * edge.length();
  const Point along = edge.along();
  const Point inwards = edge.inwards();
  const auto low = [](double a, double b) {
    return static_cast<int>(std::floor(std::min(a, b) - kReach_px));
  };
  const auto high = [](double a, double b) {
    return static_cast<int>(std::ceil(std::max(a, b) + kReach_px));
  };
  const int x0 = std::max(0, low(edge.from.x, edge.to.x) - mosaic.x0);
  const int x1 = std::min(mosaic.width(), high(edge.from.x, edge.to.x) - mosaic.x0);
  const int y0 = std::max(0, low(edge.from.y, edge.to.y) - mosaic.y0);
  const int y1 = std::min(mosaic.height(), high(edge.from.y, edge.to.y) - mosaic.y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const double dx = mosaic.x0 + x + 0.5 - edge.from.x;
      const double dy = mosaic.y0 + y + 0.5 - edge.from.y;
      const double t = dx * along.x + dy * along.y;
      const double s = dx * inwards.x + dy * inwards.y;
      const double white = mosaic.spectralon(x, y);
      if (std::abs(s) > kReach_px || t < first || t >= last || mosaic.mask(x, y) != 0 ||
          white <= kReadNoiseDn / 4) {
        continue;
      }
      const double place = (t - first) / (last - first) * segments;
      const int segment = std::min(segments - 1, static_cast<int>(place));
      // Shot noise: variance of skin / white goes as 1 / white, beneath the read noise as 1 / white^2.
      const double weight = white * white / (white + kReadNoiseDn);
      samples.push_back(
          {s, t, mosaic.scale * mosaic.skin(x, y) / white, weight, segment, 2 * (place - segment) - 1});
    }
  }
  return samples;
}

struct Model {
  double from = 0.0, to = 0.0, blur = kFirstBlur_px;
  std::vector<std::array<double, kPerSegment>> levels;
};

// Value of the model and its derivatives by the shared parameters and by the sample's segment's.
double Evaluate(const Model& m, const Sample& p, double length,
                std::array<double, kShared + kPerSegment>& gradient) {
  const auto& [outside, inside, across, along] = m.levels[static_cast<std::size_t>(p.segment)];
  const double share = p.t / length;
  const double d = p.s - (m.from * (1 - share) + m.to * share);
  const double z = d / m.blur;
  const double e = 0.5 * (1.0 + std::erf(z / std::sqrt(2.0)));
  const double bell = std::exp(-0.5 * z * z) / std::sqrt(2.0 * kPi) / m.blur;
  const double lit = inside + across * d + along * p.u;
  const double by_distance = across * e + (lit - outside) * bell;
  gradient = {-by_distance * (1 - share),
              -by_distance * share,
              -(lit - outside) * bell * z,
              1.0 - e,
              e,
              d * e,
              p.u * e};
  return outside * (1.0 - e) + lit * e;
}

// Levels from the samples that lie clear of the edge.
bool StartLevels(const std::vector<Sample>& samples, int segments, Model& model) {
  std::vector<std::array<double, 4>> sums(static_cast<std::size_t>(segments), {0, 0, 0, 0});
  for (const Sample& p : samples) {
    auto& s = sums[static_cast<std::size_t>(p.segment)];
    if (p.s < -2.0) s[0] += p.weight * p.value, s[1] += p.weight;
    if (p.s > 2.0) s[2] += p.weight * p.value, s[3] += p.weight;
  }
  for (const auto& s : sums) {
    if (!(s[1] > 0.0) || !(s[3] > 0.0)) return false;
    model.levels.push_back({s[0] / s[1], s[2] / s[3], 0.0, 0.0});
  }
  return true;
}

// One step; returns the scale of a weighted residual (robust standard deviation).
double Step(const std::vector<Sample>& samples, double length, Model& model, Eigen::MatrixXd& normal) {
  const auto unknowns = static_cast<Eigen::Index>(kShared + kPerSegment * model.levels.size());
  std::array<double, kShared + kPerSegment> g;
  std::vector<float> residuals;
  for (const Sample& p : samples) {
    residuals.push_back(static_cast<float>(std::sqrt(p.weight) * (p.value - Evaluate(model, p, length, g))));
  }
  const double sigma = std::max(1e-9, MedianAndScatter(residuals).sigma);
  normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Sample& p = samples[k];
    const double r = p.value - Evaluate(model, p, length, g);
    const double robust = std::min(1.0, kHuber * sigma / std::max(1e-12, std::abs(double(residuals[k]))));
    const double weight = robust * p.weight;
    const auto index = [&](int i) {
      return static_cast<Eigen::Index>(i < kShared ? i : kShared + kPerSegment * p.segment + (i - kShared));
    };
    for (int i = 0; i < kShared + kPerSegment; ++i) {
      right(index(i)) += weight * g[i] * r;
      for (int j = 0; j <= i; ++j) normal(index(i), index(j)) += weight * g[i] * g[j];
    }
  }
  normal.diagonal().array() *= 1.0 + 1e-6;
  const Eigen::VectorXd step = normal.selfadjointView<Eigen::Lower>().ldlt().solve(right);
  model.from += std::clamp(step(0), -0.7, 0.7);
  model.to += std::clamp(step(1), -0.7, 0.7);
  model.blur = std::clamp(model.blur + std::clamp(step(2), -0.2, 0.2), kLeastBlur_px, kMostBlur_px);
  for (std::size_t i = 0; i < model.levels.size(); ++i) {
    for (int j = 0; j < kPerSegment; ++j) {
      model.levels[i][j] += step(static_cast<Eigen::Index>(kShared + kPerSegment * i) + j);
    }
  }
  return sigma;
}

}  // namespace

double Edge::length() const {
  return std::hypot(to.x - from.x, to.y - from.y);
}
Point Edge::along() const {
  return {(to.x - from.x) / length(), (to.y - from.y) / length()};
}
Point Edge::inwards() const {
  return {-along().y, along().x};
}
Point Edge::At(double t, double s) const {
  const Point a = along();
  return {from.x + t * a.x - s * a.y, from.y + t * a.y + s * a.x};
}

std::optional<EdgeShift> FitEdgeModel(const Mosaic& mosaic, const Edge& edge) {
  const double length = edge.length();
  const int segments = std::max(1, static_cast<int>((1.0 - 2.0 * kCornerShare) * length / kSegment_px));
  const std::vector<Sample> samples = Collect(mosaic, edge, segments);
  Model model;
  if (samples.size() < static_cast<std::size_t>(50 * segments) || !StartLevels(samples, segments, model)) {
    return std::nullopt;
  }
  Eigen::MatrixXd normal;
  double sigma = 0.0;
  for (int i = 0; i < kIterations; ++i) sigma = Step(samples, length, model, normal);
  if (!std::isfinite(model.from) || !std::isfinite(model.to) || std::abs(model.from) > kFarthest_px ||
      std::abs(model.to) > kFarthest_px) {
    return std::nullopt;
  }
  Eigen::VectorXd middle = Eigen::VectorXd::Zero(normal.rows());
  middle(0) = middle(1) = 0.5;
  const double variance = middle.dot(normal.selfadjointView<Eigen::Lower>().ldlt().solve(middle));
  return EdgeShift{model.from, model.to, model.blur, sigma * std::sqrt(std::max(0.0, variance))};
}

}  // namespace dermap
