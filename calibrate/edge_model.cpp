// SPDX-License-Identifier: Apache-2.0
// Gauss-Newton on the model of four blurred edges, photosites weighted by their light and, robustly, by their
// residuals: hairs, frayed tape and bits of dust are outliers.
#include "calibrate/edge_model.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibrate/edge_loss.h"
#include "calibrate/edge_normal.h"
#include "calibrate/edge_samples.h"
#include "calibrate/statistics.h"

namespace dermap {
namespace {

constexpr std::size_t kFewestInSegment = 40;
constexpr double kFirstBlur_px = 0.7;
constexpr double kLeastBlur_px = 0.3;  // a photosite's area alone: 1 / sqrt(12)
constexpr double kMostBlur_px = 6.0;
constexpr double kSettled_px = 0.002;  // a step that moves no edge farther is the last
constexpr int kIterations = 40;
constexpr int kRedescendFrom = 4;   // iteration from which outliers count for nothing
constexpr double kHuber = 2.5;      // robust sigmas
constexpr double kRedescend = 4.0;  // robust sigmas at which a sample's weight is a quarter
constexpr double kModelScatter =
    0.02;  // of the step: what a photosite's square area makes of it that no Gaussian does
constexpr double kModelError_px = 0.05;  // of an edge, beyond its noise: measured on the simulated bench
constexpr double kFarthest_px = 2.5;     // shift from where the edge was thought to be

// exp(-x^0.66) as exponentials exp(-x / length), within 0.006 for x from 0.03 to 15.
struct Exponential {
  double length, share;
};
constexpr std::array<Exponential, 3> kLoss{{{0.0451, 0.1199}, {0.4949, 0.3973}, {2.2823, 0.4828}}};
constexpr double kShortest_px = 0.05;        // shorter exponentials are no different
constexpr double kShortestLength_mm = 0.03;  // shorter ones look like an edge that lies elsewhere
// A target either spreads light, and loses half of it right at the edge (0.92 to 0.97 of that half by the
// exact optics, since some light hardly moves), or does not spread it at all.
constexpr double kSpreads = 0.94, kSpreadsNot = 0.0, kShareSigma = 0.02;
// What is expected of the parameters that noise alone would leave open, and one standard deviation.
constexpr double kLength_mm = 0.1, kLengthSigma = 0.8;  // of its logarithm
constexpr double kAcrossSigma = 0.3;                    // change of the level over the reach, relative

constexpr int kBlur = 0;
constexpr int kLossShare = 1;
constexpr int kLossLength = 2;                 // its logarithm
constexpr int kShifts = 3;                     // first of the edges' shifts, two an edge
constexpr int kPerSegment = EdgeNormal::kOwn;  // outside, inside, its slopes across and along
static_assert(EdgeNormal::kShared == kShifts + 8);
constexpr int kSharedTerms = kShifts + 2;  // of one sample
constexpr double kBeyond = 7.0;            // widths of the blur outside of which no light of the inside falls

struct Model {
  double blur = kFirstBlur_px;
  double expected_share = kSpreads;
  double share = kSpreads;
  double log_length = std::log(kLength_mm);
  double surface = 0.0;  // of the inside, that loses nothing
  std::array<double, 8> shift{};
  std::vector<std::array<double, kPerSegment>> levels;
  std::array<double, 4> length{};
  std::array<EdgeReach, 4> reach{};
};

struct Terms {
  int edge = 0, segment = 0;
  std::array<double, kSharedTerms> shared{};  // by blur, share, length, and the edge's two shifts
  EdgeNormal::Own own{};
  // Index of a shared parameter.
  int Index(int i) const { return i < kShifts ? i : kShifts + 2 * edge + (i - kShifts); }
};

struct Loss {
  EdgeLoss loss;
  double by_log_length;
};

// Of light under the tape, for a target that loses half at the edge.
Loss LossOf(const Model& m, const EdgeReach& reach, double d) {
  Loss out{};
  for (const Exponential& e : kLoss) {
    const double length = std::max(kShortest_px, e.length * std::exp(m.log_length) * reach.px_per_mm);
    const EdgeLoss one = BlurredLoss(d, length, m.blur);
    out.loss.loss += e.share * one.loss;
    out.loss.by_distance += e.share * one.by_distance;
    out.loss.by_blur += e.share * one.by_blur;
    // The loss does not change where distance, blur and length all grow alike.
    out.by_log_length -= e.share * (d * one.by_distance + m.blur * one.by_blur);
  }
  return out;
}

// Value of the model at a sample and its derivatives by the parameters that it depends on.
double Evaluate(const Model& m, const EdgeSample& p, Terms& out) {
  const auto& [outside, inside, across, along] = m.levels[static_cast<std::size_t>(p.segment)];
  const auto edge = static_cast<std::size_t>(p.edge);
  const double share = p.t / m.length[edge];
  const double d = p.s - (m.shift[2 * edge] * (1 - share) + m.shift[2 * edge + 1] * share);
  out = {p.edge, p.segment, {}, {}};
  const double z = d / m.blur;
  if (z < -kBeyond) {
    out.own[0] = 1.0;
    return outside;
  }
  const double e = NormalIntegral(z);
  const double bell = NormalDensity(z);
  const double ramp = d * e + m.blur * bell;  // the blurred ramp that begins at the edge
  const double step = inside + along * p.u - outside;
  double value = outside + step * e + across * ramp;
  double by_distance = step * bell / m.blur + across * e;
  double by_blur = -step * bell * z / m.blur + across * bell;
  double by_inside = e;
  const Loss lost = LossOf(m, m.reach[edge], d);
  const double loses = inside - m.surface;
  value -= loses * m.share * lost.loss.loss;
  by_distance -= loses * m.share * lost.loss.by_distance;
  by_blur -= loses * m.share * lost.loss.by_blur;
  by_inside -= m.share * lost.loss.loss;
  out.shared[kBlur] = by_blur;
  out.shared[kLossShare] = -loses * lost.loss.loss;
  out.shared[kLossLength] = -loses * m.share * lost.by_log_length;
  out.shared[kShifts] = -by_distance * (1 - share);
  out.shared[kShifts + 1] = -by_distance * share;
  out.own = {1.0 - e, by_inside, ramp, p.u * e};
  return value;
}

// Levels from the samples that lie clear of the edge. False where a stretch has none.
bool StartLevels(const std::vector<EdgeSample>& samples, std::size_t segments, Model& model) {
  std::vector<std::array<std::vector<float>, 2>> sides(segments);
  for (const EdgeSample& p : samples) {
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

// Of a weighted residual: noise, and what the model itself leaves.
double Scale(const Model& model, const EdgeSample& p, double sigma) {
  const auto& level = model.levels[static_cast<std::size_t>(p.segment)];
  const double of_model = (level[1] - level[0]) * kModelScatter;
  return std::sqrt(sigma * sigma + of_model * of_model * p.weight);
}

double RobustWeight(double sigmas, bool redescend) {
  if (!redescend) return std::min(1.0, kHuber / std::max(1e-12, sigmas));
  const double q = sigmas / kRedescend;
  return 1.0 / ((1.0 + q * q) * (1.0 + q * q));
}

// Pulls what noise alone would leave open towards none.
void AddPriors(const Model& model, double sigma, EdgeNormal& normal) {
  const auto pull = [&](double value, double width, double& diagonal, double& right) {
    const double weight = sigma * sigma / (width * width);
    diagonal += weight;
    right -= weight * value;
  };
  pull(model.share - model.expected_share, kShareSigma, normal.shared[kLossShare][kLossShare],
       normal.right[kLossShare]);
  pull(model.log_length - std::log(kLength_mm), kLengthSigma, normal.shared[kLossLength][kLossLength],
       normal.right[kLossLength]);
  for (std::size_t g = 0; g < model.levels.size(); ++g) {
    const double width =
        kAcrossSigma * std::max(0.01, std::abs(model.levels[g][1])) / model.reach[0].inside_px;
    pull(model.levels[g][2], width, normal.stretches[g].own[2][2], normal.stretches[g].right[2]);
  }
}

void Add(const Terms& t, double weight, double residual, EdgeNormal& normal) {
  EdgeNormal::Stretch& stretch = normal.stretches[static_cast<std::size_t>(t.segment)];
  for (int i = 0; i < kSharedTerms; ++i) {  // indices ascend: the lower triangle
    const double weighted = weight * t.shared[i];
    const int row = t.Index(i);
    normal.right[row] += weighted * residual;
    for (int j = 0; j <= i; ++j) normal.shared[row][t.Index(j)] += weighted * t.shared[j];
    for (int j = 0; j < kPerSegment; ++j) stretch.cross[j][row] += weighted * t.own[j];
  }
  for (int i = 0; i < kPerSegment; ++i) {
    stretch.right[i] += weight * t.own[i] * residual;
    for (int j = 0; j <= i; ++j) stretch.own[i][j] += weight * t.own[i] * t.own[j];
  }
}

void Move(const EdgeStep& step, Model& model) {
  model.blur =
      std::clamp(model.blur + std::clamp(step.shared[kBlur], -0.2, 0.2), kLeastBlur_px, kMostBlur_px);
  model.share += std::clamp(step.shared[kLossShare], -0.3, 0.3);
  model.log_length = std::max(std::log(kShortestLength_mm),
                              model.log_length + std::clamp(step.shared[kLossLength], -0.7, 0.7));
  for (std::size_t i = 0; i < model.shift.size(); ++i)
    model.shift[i] += std::clamp(step.shared[kShifts + i], -0.7, 0.7);
  for (std::size_t g = 0; g < model.levels.size(); ++g) {
    for (std::size_t j = 0; j < kPerSegment; ++j) model.levels[g][j] += step.own[g][j];
  }
}

// One step; returns the scale of a weighted residual (robust standard deviation).
double Step(const std::vector<EdgeSample>& samples, bool redescend, Model& model, EdgeNormal& normal) {
  std::vector<Terms> terms(samples.size());
  std::vector<float> residuals(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double r = samples[k].value - Evaluate(model, samples[k], terms[k]);
    residuals[k] = static_cast<float>(std::sqrt(samples[k].weight) * r);
  }
  const double sigma = std::max(1e-9, MedianAndScatter(residuals).sigma);
  normal = {};
  normal.stretches.resize(model.levels.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double scale = Scale(model, samples[k], sigma);
    const double weight = samples[k].weight * RobustWeight(std::abs(residuals[k]) / scale, redescend);
    Add(terms[k], weight, residuals[k] / std::sqrt(samples[k].weight), normal);
  }
  AddPriors(model, sigma, normal);
  Move(Solve(normal), model);
  return sigma;
}

struct Fitted {
  Model model;
  EdgeNormal normal;
  double sigma = 0.0;
};

Fitted Fit(const std::vector<EdgeSample>& samples, Model start, double expected_share) {
  Fitted fitted{std::move(start), {}, 0.0};
  fitted.model.expected_share = fitted.model.share = expected_share;
  for (int i = 0; i < kIterations; ++i) {
    const auto before = fitted.model.shift;
    fitted.sigma = Step(samples, i >= kRedescendFrom, fitted.model, fitted.normal);
    double moved = 0.0;
    for (std::size_t k = 0; k < before.size(); ++k)
      moved = std::max(moved, std::abs(fitted.model.shift[k] - before[k]));
    if (i > kRedescendFrom && moved < kSettled_px) break;
  }
  return fitted;
}

// Of all samples, in squares of their scale; one that lies far off counts no more than any other that does.
double Misfit(const std::vector<EdgeSample>& samples, const Model& model, double sigma) {
  double sum = 0.0;
  Terms unused;
  for (const EdgeSample& p : samples) {
    const double r = p.value - Evaluate(model, p, unused);
    const double q2 = p.weight * r * r / std::pow(kRedescend * Scale(model, p, sigma), 2);
    sum += q2 / (1.0 + q2);
  }
  return sum;
}

// Standard deviation of an edge's shift in its middle.
double Uncertainty(const EdgeNormal& normal, int edge, double sigma) {
  EdgeNormal::Shared middle{};
  middle[kShifts + 2 * edge] = middle[kShifts + 2 * edge + 1] = 0.5;
  return std::hypot(sigma * std::sqrt(std::max(0.0, VarianceAlong(normal, middle))), kModelError_px);
}

}  // namespace

std::optional<std::array<EdgeShift, 4>> FitEdges(const Mosaic& mosaic, const std::array<Edge, 4>& edges,
                                                 double window_mm, std::size_t most_samples) {
  const EdgeSamples samples = CollectEdgeSamples(mosaic, edges, window_mm, most_samples);
  const auto count = static_cast<std::size_t>(samples.segments);
  Model start;
  start.reach = samples.reach;
  start.surface = mosaic.surface;
  for (std::size_t i = 0; i < 4; ++i) start.length[i] = edges[i].length();
  if (samples.samples.size() < kFewestInSegment * count || !StartLevels(samples.samples, count, start))
    return std::nullopt;
  const Fitted spreads = Fit(samples.samples, start, kSpreads);
  const Fitted spreads_not = Fit(samples.samples, start, kSpreadsNot);
  const double sigma = std::min(spreads.sigma, spreads_not.sigma);
  const bool skin =
      Misfit(samples.samples, spreads.model, sigma) < Misfit(samples.samples, spreads_not.model, sigma);
  const Fitted& fitted = skin ? spreads : spreads_not;
  for (const double shift : fitted.model.shift) {
    if (!std::isfinite(shift) || std::abs(shift) > kFarthest_px) return std::nullopt;
  }
  std::array<EdgeShift, 4> shifts;
  for (std::size_t i = 0; i < 4; ++i) {
    shifts[i] = {fitted.model.shift[2 * i], fitted.model.shift[2 * i + 1], fitted.model.blur,
                 Uncertainty(fitted.normal, static_cast<int>(i), fitted.sigma)};
  }
  return shifts;
}

}  // namespace dermap
