// SPDX-License-Identifier: Apache-2.0
// Gauss-Newton on the model of four blurred edges, photosites weighted by their light and, robustly, by their
// residuals: hairs, frayed tape and bits of dust are outliers.
#include "calibrate/edge_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "calibrate/edge_loss.h"
#include "calibrate/statistics.h"

namespace dermap {
namespace {

constexpr double kLeastReach_px = 7.0;  // to either side
constexpr double kMostInside_px = 40.0;
constexpr double kMostOutside_px = 12.0;
constexpr double kInside_mm = 0.45;  // how far skin is seen to darken towards the tape
constexpr double kOutside_mm = 0.2;
constexpr double kSegment_px = 24.0;  // along, with levels of its own; longer on edges of many photosites
constexpr int kMostSegments = 12;     // an edge
constexpr std::size_t kMostSamples = 30000;
constexpr double kFirstBlur_px = 0.7;
constexpr double kLeastBlur_px = 0.3;  // a photosite's area alone: 1 / sqrt(12)
constexpr double kMostBlur_px = 6.0;
constexpr double kSettled_px = 0.002;  // a step that moves no edge farther is the last
constexpr int kIterations = 12;
constexpr int kRedescendFrom = 4;   // iteration from which outliers count for nothing
constexpr double kHuber = 2.5;      // robust sigmas
constexpr double kRedescend = 4.0;  // robust sigmas at which a sample's weight is a quarter
constexpr double kModelScatter =
    0.02;  // of the step: what a photosite's square area makes of it that no Gaussian does
constexpr double kReadNoiseDn = 20.0;    // signal at which shot noise equals read noise, about
constexpr double kModelError_px = 0.05;  // of an edge, beyond its noise: measured on the simulated bench
constexpr double kFarthest_px = 2.5;     // shift from where the edge was thought to be

// Lengths of the exponentials that stand for skin's loss, mm.
constexpr std::array<double, 2> kLengths_mm{0.06, 0.2};
constexpr int kSpreads = static_cast<int>(kLengths_mm.size());
// What is expected of the parameters that noise alone would leave open: one standard deviation.
constexpr double kShareSigma = 0.5;
constexpr double kAcrossSigma = 0.3;  // change of the level over the reach, relative

constexpr int kBlur = 0;
constexpr int kShares = 1;                   // first of the w_k
constexpr int kShifts = kShares + kSpreads;  // first of the edges' shifts, two an edge
constexpr int kShared = kShifts + 8;
constexpr int kPerSegment = 4;  // outside, inside, its slopes across and along
constexpr int kTerms = 1 + kSpreads + 2 + kPerSegment;

struct Reach {
  double inside_px, outside_px, px_per_mm;
};

Reach ReachOf(const std::array<Edge, 4>& edges, std::size_t i, double window_mm) {
  // Across an edge the picture's scale is that of its two neighbours.
  const double px_per_mm = 0.5 * (edges[(i + 1) % 4].length() + edges[(i + 3) % 4].length()) / window_mm;
  return {std::clamp(kInside_mm * px_per_mm, kLeastReach_px, kMostInside_px),
          std::clamp(kOutside_mm * px_per_mm, kLeastReach_px, kMostOutside_px), px_per_mm};
}

struct Sample {
  double s, t;   // inwards of and along the edge as it was thought to be
  double value;  // reflectance
  double weight;
  int edge;
  int segment;  // of all edges
  double u;     // along within the segment, -1 ... 1
};

void Collect(const Mosaic& mosaic, const Edge& edge, const Reach& reach, int index, int first_segment,
             int segments, std::vector<Sample>& samples) {
  const double first = kCornerShare * edge.length();
  const double last = (1.0 - kCornerShare) * edge.length();
  const Point along = edge.along();
  const Point inwards = edge.inwards();
  const Point a = mosaic.lens.PhotositesFromIdeal(edge.from);
  const Point b = mosaic.lens.PhotositesFromIdeal(edge.to);
  const Point m = mosaic.lens.PhotositesFromIdeal(edge.At(0.5 * edge.length(), 0.0));
  const double bow = std::hypot(m.x - 0.5 * (a.x + b.x), m.y - 0.5 * (a.y + b.y));
  const double margin = std::max(reach.inside_px, reach.outside_px) + bow;
  const auto low = [&](double p, double q) { return static_cast<int>(std::floor(std::min(p, q) - margin)); };
  const auto high = [&](double p, double q) { return static_cast<int>(std::ceil(std::max(p, q) + margin)); };
  const int x0 = std::max(0, low(a.x, b.x) - mosaic.x0);
  const int x1 = std::min(mosaic.width(), high(a.x, b.x) - mosaic.x0);
  const int y0 = std::max(0, low(a.y, b.y) - mosaic.y0);
  const int y1 = std::min(mosaic.height(), high(a.y, b.y) - mosaic.y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const Point ideal = mosaic.lens.IdealFromPhotosites({mosaic.x0 + x + 0.5, mosaic.y0 + y + 0.5});
      const double dx = ideal.x - edge.from.x;
      const double dy = ideal.y - edge.from.y;
      const double t = dx * along.x + dy * along.y;
      const double s = dx * inwards.x + dy * inwards.y;
      const double white = mosaic.spectralon(x, y);
      if (s > reach.inside_px || s < -reach.outside_px || t < first || t >= last || mosaic.mask(x, y) != 0 ||
          white <= kReadNoiseDn / 4) {
        continue;
      }
      const double place = (t - first) / (last - first) * segments;
      const int segment = std::min(segments - 1, static_cast<int>(place));
      // Shot noise: variance of skin / white goes as 1 / white, beneath the read noise as 1 / white^2.
      const double weight = white * white / (white + kReadNoiseDn);
      samples.push_back({s, t, mosaic.scale * mosaic.skin(x, y) / white, weight, index,
                         first_segment + segment, 2 * (place - segment) - 1});
    }
  }
}

// Every n-th sample of a window of many photosites; n is odd, so that all colours stay.
void Thin(std::vector<Sample>& samples) {
  std::size_t every = samples.size() / kMostSamples + 1;
  if (every == 1) return;
  every |= 1U;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.size(); i += every) samples[kept++] = samples[i];
  samples.resize(kept);
}

struct Model {
  double blur = kFirstBlur_px;
  std::array<double, kSpreads> share{};
  std::array<double, 8> shift{};
  std::vector<std::array<double, kPerSegment>> levels;
  std::array<double, 4> length{};
  std::array<Reach, 4> reach{};
};

struct Terms {
  std::array<int, kTerms> index;
  std::array<double, kTerms> gradient;
};

// Value of the model at a sample and its derivatives by the parameters that it depends on.
double Evaluate(const Model& m, const Sample& p, Terms& out) {
  const auto& [outside, inside, across, along] = m.levels[static_cast<std::size_t>(p.segment)];
  const auto edge = static_cast<std::size_t>(p.edge);
  const double share = p.t / m.length[edge];
  const double d = p.s - (m.shift[2 * edge] * (1 - share) + m.shift[2 * edge + 1] * share);
  const double z = d / m.blur;
  const double e = NormalIntegral(z);
  const double bell = NormalDensity(z);
  const double ramp = d * e + m.blur * bell;  // the blurred ramp that begins at the edge
  const double step = inside + along * p.u - outside;
  double value = outside + step * e + across * ramp;
  double by_distance = step * bell / m.blur + across * e;
  double by_blur = -step * bell * z / m.blur + across * bell;
  double by_inside = e;
  for (int k = 0; k < kSpreads; ++k) {
    const EdgeLoss loss =
        BlurredLoss(d, kLengths_mm[static_cast<std::size_t>(k)] * m.reach[edge].px_per_mm, m.blur);
    const double w = m.share[static_cast<std::size_t>(k)];
    value -= inside * w * loss.loss;
    by_distance -= inside * w * loss.by_distance;
    by_blur -= inside * w * loss.by_blur;
    by_inside -= w * loss.loss;
    out.index[1 + k] = kShares + k;
    out.gradient[1 + k] = -inside * loss.loss;
  }
  out.index[0] = kBlur;
  out.gradient[0] = by_blur;
  const int at = 1 + kSpreads;
  for (int i = 0; i < 2; ++i) {
    out.index[at + i] = kShifts + 2 * p.edge + i;
    out.gradient[at + i] = -by_distance * (i == 0 ? 1 - share : share);
  }
  const std::array<double, kPerSegment> own{1.0 - e, by_inside, ramp, p.u * e};
  for (int i = 0; i < kPerSegment; ++i) {
    out.index[at + 2 + i] = kShared + kPerSegment * p.segment + i;
    out.gradient[at + 2 + i] = own[static_cast<std::size_t>(i)];
  }
  return value;
}

// Levels from the samples that lie clear of the edge. False where a stretch has none.
bool StartLevels(const std::vector<Sample>& samples, std::size_t segments, Model& model) {
  std::vector<std::array<std::vector<float>, 2>> sides(segments);
  for (const Sample& p : samples) {
    auto& side = sides[static_cast<std::size_t>(p.segment)];
    if (p.s < -2.0) side[0].push_back(static_cast<float>(p.value));
    if (p.s > 2.0) side[1].push_back(static_cast<float>(p.value));
  }
  for (auto& side : sides) {
    if (side[0].empty() || side[1].empty()) return false;
    model.levels.push_back({Median(std::move(side[0])), Median(std::move(side[1])), 0.0, 0.0});
  }
  return true;
}

double RobustWeight(double sigmas, bool redescend) {
  if (!redescend) return std::min(1.0, kHuber / std::max(1e-12, sigmas));
  const double q = sigmas / kRedescend;
  return 1.0 / ((1.0 + q * q) * (1.0 + q * q));
}

// Pulls what noise alone would leave open towards none.
void AddPriors(const Model& model, double sigma, Eigen::MatrixXd& normal, Eigen::VectorXd& right) {
  const auto pull = [&](Eigen::Index i, double value, double width) {
    const double weight = sigma * sigma / (width * width);
    normal(i, i) += weight;
    right(i) -= weight * value;
  };
  for (int k = 0; k < kSpreads; ++k) pull(kShares + k, model.share[static_cast<std::size_t>(k)], kShareSigma);
  for (std::size_t g = 0; g < model.levels.size(); ++g) {
    const double width =
        kAcrossSigma * std::max(0.01, std::abs(model.levels[g][1])) / model.reach[0].inside_px;
    pull(static_cast<Eigen::Index>(kShared + kPerSegment * g) + 2, model.levels[g][2], width);
  }
}

void Move(const Eigen::VectorXd& step, Model& model) {
  model.blur = std::clamp(model.blur + std::clamp(step(kBlur), -0.2, 0.2), kLeastBlur_px, kMostBlur_px);
  for (int k = 0; k < kSpreads; ++k)
    model.share[static_cast<std::size_t>(k)] += std::clamp(step(kShares + k), -0.3, 0.3);
  for (int i = 0; i < 8; ++i)
    model.shift[static_cast<std::size_t>(i)] += std::clamp(step(kShifts + i), -0.7, 0.7);
  for (std::size_t g = 0; g < model.levels.size(); ++g) {
    for (int j = 0; j < kPerSegment; ++j) {
      model.levels[g][static_cast<std::size_t>(j)] +=
          step(static_cast<Eigen::Index>(kShared + kPerSegment * g) + j);
    }
  }
}

// One step; returns the scale of a weighted residual (robust standard deviation).
double Step(const std::vector<Sample>& samples, bool redescend, Model& model, Eigen::MatrixXd& normal) {
  const auto unknowns = static_cast<Eigen::Index>(kShared + kPerSegment * model.levels.size());
  std::vector<Terms> terms(samples.size());
  std::vector<float> residuals(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double r = samples[k].value - Evaluate(model, samples[k], terms[k]);
    residuals[k] = static_cast<float>(std::sqrt(samples[k].weight) * r);
  }
  const double sigma = std::max(1e-9, MedianAndScatter(residuals).sigma);
  normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto& level = model.levels[static_cast<std::size_t>(samples[k].segment)];
    const double own = std::abs(level[1] - level[0]) * kModelScatter * std::sqrt(samples[k].weight);
    const double scale = std::hypot(sigma, own);
    const double weight = samples[k].weight * RobustWeight(std::abs(residuals[k]) / scale, redescend);
    const double r = residuals[k] / std::sqrt(samples[k].weight);
    const Terms& t = terms[k];
    for (int i = 0; i < kTerms; ++i) {  // indices ascend: the lower triangle
      right(t.index[i]) += weight * t.gradient[i] * r;
      for (int j = 0; j <= i; ++j) normal(t.index[i], t.index[j]) += weight * t.gradient[i] * t.gradient[j];
    }
  }
  AddPriors(model, sigma, normal, right);
  normal.diagonal().array() *= 1.0 + 1e-9;
  Move(normal.selfadjointView<Eigen::Lower>().ldlt().solve(right), model);
  return sigma;
}

// Standard deviation of an edge's shift in its middle.
double Uncertainty(const Eigen::LDLT<Eigen::MatrixXd>& solver, Eigen::Index unknowns, int edge,
                   double sigma) {
  Eigen::VectorXd middle = Eigen::VectorXd::Zero(unknowns);
  middle(kShifts + 2 * edge) = middle(kShifts + 2 * edge + 1) = 0.5;
  return std::hypot(sigma * std::sqrt(std::max(0.0, middle.dot(solver.solve(middle)))), kModelError_px);
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

std::optional<std::array<EdgeShift, 4>> FitEdges(const Mosaic& mosaic, const std::array<Edge, 4>& edges,
                                                 double window_mm) {
  Model model;
  std::vector<Sample> samples;
  int segments = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    model.length[i] = edges[i].length();
    model.reach[i] = ReachOf(edges, i, window_mm);
    const int own = std::clamp(static_cast<int>((1.0 - 2.0 * kCornerShare) * model.length[i] / kSegment_px),
                               1, kMostSegments);
    Collect(mosaic, edges[i], model.reach[i], static_cast<int>(i), segments, own, samples);
    segments += own;
  }
  Thin(samples);
  const auto count = static_cast<std::size_t>(segments);
  if (samples.size() < 50 * count || !StartLevels(samples, count, model)) return std::nullopt;
  Eigen::MatrixXd normal;
  double sigma = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const auto before = model.shift;
    sigma = Step(samples, i >= kRedescendFrom, model, normal);
    double moved = 0.0;
    for (std::size_t k = 0; k < before.size(); ++k)
      moved = std::max(moved, std::abs(model.shift[k] - before[k]));
    if (i > kRedescendFrom && moved < kSettled_px) break;
  }
  for (const double shift : model.shift) {
    if (!std::isfinite(shift) || std::abs(shift) > kFarthest_px) return std::nullopt;
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal.selfadjointView<Eigen::Lower>());
  std::array<EdgeShift, 4> shifts;
  for (std::size_t i = 0; i < 4; ++i) {
    shifts[i] = {model.shift[2 * i], model.shift[2 * i + 1], model.blur,
                 Uncertainty(solver, normal.rows(), static_cast<int>(i), sigma)};
  }
  return shifts;
}

}  // namespace dermap
