// SPDX-License-Identifier: Apache-2.0
// Linearising, coarsening, and the solution from the mean to the finest detail.
#include "fit/octave_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "common/core/parallel.h"
#include "fit/resample.h"
#include "fit/small_system.h"

namespace dermap {
namespace {

// Details of a plane span three quarters of its pixels' dimensions, so a detail of variance v a pixel has 4/3
// v in each of those.
constexpr double kDetailShare = 0.75;
constexpr double kSmallestVariance = 1e-9, kLargestVariance = 1.0;  // scaled units: 1 is the range's
// An octave's variance is guessed to fall from that of the next coarser one as that fell from the one before,
// within limits: natural maps hold less detail the finer it is. The guess counts as if so many pixels, and
// such a share of all, had been seen: it decides where an octave has a handful of pixels or the data hardly
// reach.
constexpr double kSteepestFall = 0.06, kGuessFall = 0.5, kGuessPixels = 2.0, kGuessShare = 0.02;
// Guessed scatter counts as if so many data had been seen.
constexpr double kScatterData = 40.0;

std::vector<PlaneF> HalveAll(const std::vector<PlaneF>& planes) {
  std::vector<PlaneF> halved;
  for (const PlaneF& plane : planes) halved.push_back(Halve(plane));
  return halved;
}

std::vector<PlaneF> DoubleAll(const std::vector<PlaneF>& planes, GridShape shape) {
  std::vector<PlaneF> doubled(planes.size());
  ParallelFor(static_cast<int>(planes.size()), [&](int i) { doubled[i] = Double(planes[i], shape); });
  return doubled;
}

std::vector<PlaneF> Zeros(std::size_t count, GridShape shape) {
  return std::vector<PlaneF>(count, PlaneF(shape.width, shape.height));
}

void AddPlane(const PlaneF& add, float factor, PlaneF& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum.data()[i] += factor * add.data()[i];
}

}  // namespace

DetailPrior FirstPrior(int octaves) {
  FreeVector variance;
  variance.fill(kFirstDetailSigma * kFirstDetailSigma);
  DetailPrior prior(octaves, variance);
  prior.back().fill(kLargestVariance);
  return prior;
}

double GuessedVariance(const DetailPrior& prior, int octave, int j) {
  const int top = static_cast<int>(prior.size()) - 1;
  if (octave + 1 >= top) return kFirstDetailSigma * kFirstDetailSigma;
  if (octave + 2 >= top) return kGuessFall * prior[octave + 1][j];
  const double fall = prior[octave + 1][j] / prior[octave + 2][j];
  return prior[octave + 1][j] * std::clamp(fall, kSteepestFall, kGuessFall);
}

// Derivatives of the logarithm of one band by the scaled free parameters, with and without skin's blur.
struct OctaveModel::Row {
  double blurred[kUnknownCount], unblurred[kUnknownCount];
  double epidermis_share;
};

struct OctaveModel::Solution {
  std::vector<PlaneF> change, variance;
  FreeVector squares{}, determined{};            // sums over pixels: detail^2, share that the data decide
  double pixels = 0.0, prior_misfit = 0.0;
  double scatter = 0.0, scatter_data = 0.0;  // sum of squares of what stays unanswered, over its noise; as many
};

OctaveModel::OctaveModel(const PatchProblem& problem, std::span<const std::vector<BlurCurve>> blur,
                         const ParameterVector& fixed)
    : problem_(problem), blur_(blur) {
  const FitData& data = problem.data();
  double side = 1.0;
  for (const GridShape shape : OctaveShapes(data.width(), data.height())) {
    Level& level = levels_.emplace_back();
    level.shape = shape;
    level.noise_inflation = MeanNoiseInflation(data, side);
    side *= 2.0;
  }
  fixed_ = fixed;
  for (const BandOptics& optics : problem.model().optics())
    absorbers_.push_back(optics.nodes[optics.center].absorbers);
}

void OctaveModel::Sense(const FitState& state, Level& level) const {
  const FitData& data = problem_.data();
  const ForwardModel& model = problem_.model();
  const ParameterSpace& space = problem_.space();
  const std::size_t bands = data.bands.size();
  level.residual = Zeros(bands, level.shape);
  level.weight = level.epidermis = level.dermis = level.residual;
  level.junction = Zeros(space.HasJunction() ? bands : 0, level.shape);
  level.position = Zeros(space.count(), level.shape);
  ParallelFor(level.shape.height, [&](int y) {
    const std::size_t begin = static_cast<std::size_t>(y) * level.shape.width;
    for (std::size_t i = begin; i < begin + level.shape.width; ++i) {
      const SkinPoint p = problem_.PointAt(state.maps, i);
      const FreeVector position = space.FromParameters(p);
      for (int j = 0; j < space.count(); ++j) level.position[j].data()[i] = static_cast<float>(position[j]);
      for (int b = 0; b < data.band_count(); ++b) {
        const LogSensitivity local = model.LocalSensitivity(b, TableOne(p), p[kParameterCount]);
        level.epidermis[b].data()[i] = static_cast<float>(local.mu_a_epidermis);
        level.dermis[b].data()[i] = static_cast<float>(local.mu_a_dermis);
        if (space.HasJunction())
          level.junction[b].data()[i] = static_cast<float>(local.junction_absorbance);
        if (!data.fitted.data()[i] || !data.Has(b, i)) continue;
        const LogResidual datum = LogResidualOf(data.measured[b].data()[i], data.sigma[b].data()[i],
                                                state.predicted[b].data()[i]);
        level.residual[b].data()[i] = static_cast<float>(datum.residual / datum.weight);
        level.weight[b].data()[i] = static_cast<float>(datum.weight * datum.weight);
      }
    }
  });
}

void OctaveModel::FillRows(int index, std::size_t pixel, std::span<Row> rows) const {
  const Level& level = levels_[index];
  const ParameterSpace& space = problem_.space();
  const bool blurs = index + 1 < octaves() && index < static_cast<int>(blur_.size());
  SkinPoint point = PointOf(fixed_, problem_.model().tissue().junction_absorbance);
  FreeVector position{};
  for (int j = 0; j < space.count(); ++j) position[j] = level.position[j].data()[pixel];
  space.ToParameters(position, point);
  const ParameterVector p = TableOne(point);
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const BlurShare seen = blurs ? blur_[index][b].At(absorbers_[b].MuAEpidermis(p)) : BlurShare{};
    const ParameterVector of_epidermis = absorbers_[b].MuAEpidermisGradient(p);
    const ParameterVector of_dermis = absorbers_[b].MuADermisGradient(p);
    const float epidermis = level.epidermis[b].data()[pixel], dermis = level.dermis[b].data()[pixel];
    const float junction = level.junction.empty() ? 0.0f : level.junction[b].data()[pixel];
    rows[b].epidermis_share = seen.epidermis;
    for (int j = 0; j < space.count(); ++j) {
      const int k = static_cast<int>(space.parameter(j));
      const bool table = k < kParameterCount;
      const double upper = table ? epidermis * of_epidermis[k] * space.scale(j) : 0.0;
      const double lower = table ? dermis * of_dermis[k] * space.scale(j) : 0.0;
      const double between = table ? 0.0 : junction * space.scale(j);
      rows[b].unblurred[j] = upper + lower + between;
      rows[b].blurred[j] = seen.epidermis * upper + seen.dermis * lower + seen.junction * between;
    }
  }
}

void OctaveModel::Coarsen(const Level& fine, Level& coarse) {
  const std::size_t bands = fine.weight.size();
  coarse.residual.resize(bands);
  coarse.weight.resize(bands);
  ParallelFor(static_cast<int>(bands), [&](int b) {
    PlaneF weighted = fine.residual[b];
    for (std::size_t i = 0; i < weighted.size(); ++i) weighted.data()[i] *= fine.weight[b].data()[i];
    coarse.residual[b] = HalveSum(weighted);
    coarse.weight[b] = HalveSum(fine.weight[b]);
    for (std::size_t i = 0; i < coarse.residual[b].size(); ++i)
      coarse.residual[b].data()[i] /= std::max(coarse.weight[b].data()[i], 1e-30f);
  });
  coarse.epidermis = HalveAll(fine.epidermis);
  coarse.dermis = HalveAll(fine.dermis);
  coarse.junction = HalveAll(fine.junction);
  coarse.position = HalveAll(fine.position);
}

void OctaveModel::Linearise(const FitState& state) {
  Sense(state, levels_[0]);
  for (int l = 0; l < octaves(); ++l) {
    Level& level = levels_[l];
    level.detail = level.position;
    if (l + 1 == octaves()) break;
    Coarsen(level, levels_[l + 1]);
    for (std::size_t j = 0; j < level.position.size(); ++j)
      AddPlane(Double(levels_[l + 1].position[j], level.shape), -1.0f, level.detail[j]);
  }
  for (std::size_t j = 0; j < levels_.back().detail.size(); ++j)
    for (float& value : levels_.back().detail[j].values())
      value -= static_cast<float>(problem_.space().mean()[j]);
}

// body(y, pixel, rows) for every pixel, with memory for the rows of all bands.
template <class Body>
void OctaveModel::ForEachPixel(GridShape shape, int bands, const Body& body) {
  ParallelFor(shape.height, [&](int y) {
    Rows rows(bands);
    const std::size_t begin = static_cast<std::size_t>(y) * shape.width;
    for (std::size_t i = begin; i < begin + shape.width; ++i) body(y, i, rows);
  });
}

OctaveModel::Solution OctaveModel::SolveLevel(int index, const FreeVector& prior, double scatter,
                                              const std::vector<PlaneF>& moved, std::vector<PlaneF>& answered,
                                              std::vector<PlaneF>& unblurred) const {
  const Level& level = levels_[index];
  const ParameterSpace& space = problem_.space();
  const int count = space.count(), bands = static_cast<int>(level.weight.size());
  const bool top = index + 1 == octaves();
  const double share = top ? 1.0 : kDetailShare;
  const double noise = level.noise_inflation * scatter;
  Solution solution;
  solution.change = solution.variance = Zeros(count, level.shape);
  std::vector<FreeVector> determined(level.shape.height);  // by row
  ForEachPixel(level.shape, bands, [&](int y, std::size_t i, Rows& rows) {
    FillRows(index, i, rows);
    SmallSystem system(count);
    FreeVector lower, upper;
    for (int b = 0; b < bands; ++b) {
      // What coarser changes do here differs from what they do on average: where there is more melanin, a
      // change of its kind does more.
      double answer = 0.0;
      for (int j = 0; j < count; ++j) answer += rows[b].unblurred[j] * moved[j].data()[i];
      float& expected = answered[b].data()[i];
      expected += static_cast<float>(rows[b].epidermis_share * (answer - unblurred[b].data()[i]));
      system.Add(rows[b].blurred, level.residual[b].data()[i] - expected, level.weight[b].data()[i] / noise);
    }
    for (int j = 0; j < count; ++j) {
      const double position = level.position[j].data()[i] + moved[j].data()[i];
      lower[j] = std::min(space.lower()[j] - position, 0.0);
      upper[j] = std::max(space.upper()[j] - position, 0.0);
      system.AddPrior(j, share / prior[j], -level.detail[j].data()[i]);
    }
    FreeVector change, variance;
    system.Solve(lower, upper, change, variance);
    for (int j = 0; j < count; ++j) {
      solution.change[j].data()[i] = static_cast<float>(change[j]);
      solution.variance[j].data()[i] = static_cast<float>(share * variance[j]);
      determined[y][j] += 1.0 - variance[j] * share / prior[j];
    }
  });
  if (!top)
    for (PlaneF& change : solution.change) change = DetailOf(change);
  ForEachPixel(level.shape, bands, [&](int, std::size_t i, Rows& rows) {
    FillRows(index, i, rows);
    for (int b = 0; b < bands; ++b) {
      double answer = 0.0, without_blur = 0.0;
      for (int j = 0; j < count; ++j) {
        const double change = solution.change[j].data()[i];
        answer += rows[b].blurred[j] * change;
        without_blur += rows[b].unblurred[j] * (moved[j].data()[i] + change);
      }
      answered[b].data()[i] += static_cast<float>(answer);
      unblurred[b].data()[i] = static_cast<float>(without_blur);
    }
  });
  for (int b = 0; b < bands; ++b) {
    PlaneF left = level.residual[b];
    AddPlane(answered[b], -1.0f, left);
    if (!top) left = DetailOf(left);
    for (std::size_t i = 0; i < left.size(); ++i) {
      const double weight = level.weight[b].data()[i] / noise;
      if (weight <= 0.0) continue;
      solution.scatter += weight * left.data()[i] * left.data()[i];
      solution.scatter_data += share;
    }
  }
  solution.pixels = static_cast<double>(level.shape.size());
  for (int j = 0; j < count; ++j) {
    for (std::size_t i = 0; i < level.shape.size(); ++i) {
      const double before = level.detail[j].data()[i], after = before + solution.change[j].data()[i];
      solution.squares[j] += after * after;
      solution.prior_misfit += share * before * before / prior[j];
    }
    for (const FreeVector& row : determined) solution.determined[j] += row[j];
  }
  return solution;
}

OctaveStep OctaveModel::Solve(std::span<const FreeVector> prior, std::span<const double> scatter) const {
  const int count = problem_.space().count(), top = octaves() - 1;
  OctaveStep step;
  step.next_prior.assign(prior.begin(), prior.end());
  std::vector<double> squares_left(octaves()), data_left(octaves());
  std::vector<PlaneF> answered = Zeros(levels_[0].weight.size(), levels_[top].shape);
  std::vector<PlaneF> unblurred = answered;
  step.change = step.variance = Zeros(count, levels_[top].shape);
  for (int l = top; l >= 0; --l) {
    if (l < top) {
      answered = DoubleAll(answered, levels_[l].shape);
      unblurred = DoubleAll(unblurred, levels_[l].shape);
      step.change = DoubleAll(step.change, levels_[l].shape);
      step.variance = DoubleAll(step.variance, levels_[l].shape);
    }
    const Solution solution = SolveLevel(l, prior[l], scatter[l], step.change, answered, unblurred);
    for (int j = 0; j < count; ++j) {
      AddPlane(solution.change[j], 1.0f, step.change[j]);
      AddPlane(solution.variance[j], 1.0f, step.variance[j]);
      step.adapted_parameters += (l == top ? 1.0 : kDetailShare) * solution.determined[j];
      if (l == top) continue;
      const double guess = GuessedVariance(step.next_prior, l, j);
      const double guess_weight = kGuessPixels + kGuessShare * solution.pixels;
      step.next_prior[l][j] = std::clamp((solution.squares[j] + guess_weight * guess) /
                                             (std::max(solution.determined[j], 0.0) + guess_weight),
                                         kSmallestVariance, kLargestVariance);
    }
    step.prior_misfit += solution.prior_misfit;
    double adapted = 0.0;
    for (int j = 0; j < count; ++j) adapted += (l == top ? 1.0 : kDetailShare) * solution.determined[j];
    squares_left[l] = solution.scatter * scatter[l];
    data_left[l] = std::max(solution.scatter_data - adapted, 0.0);
    if (std::getenv("TALK2")) { printf("  octave %d sd:", l); for (int j = 0; j < count; ++j) { double v = 0, d = 0; for (float x : solution.variance[j].values()) v += x; d = solution.determined[j]; printf(" %.5f (%.2f)", std::sqrt(v / solution.pixels), d / solution.pixels); } printf("\n"); }
  }
  step.next_scatter.resize(octaves());
  for (int l = 0; l <= top; ++l) {
    const double guess = l == 0 ? 1.0 : 1.0 + 4.0 * (step.next_scatter[l - 1] - 1.0);
    step.next_scatter[l] =
        std::max(1.0, (squares_left[l] + kScatterData * guess) / (data_left[l] + kScatterData));
    if (std::getenv("TALK2")) printf("  octave %d scatter %.3f (used %.3f, data %.1f)\n", l, step.next_scatter[l], scatter[l], data_left[l]);
  }
  double squares = 0.0;
  for (int j = 0; j < count; ++j)
    for (std::size_t i = 0; i < step.change[j].size(); ++i) {
      const double change = step.change[j].data()[i];
      squares += change * change / std::max(step.variance[j].data()[i], 1e-12f);
    }
  step.move = std::sqrt(squares / (static_cast<double>(count) * static_cast<double>(levels_[0].shape.size())));
  return step;
}

ParameterMaps OctaveModel::Apply(const ParameterMaps& maps, const OctaveStep& step) const {
  const FitData& data = problem_.data();
  const ParameterSpace& space = problem_.space();
  ParameterMaps changed = maps;
  ParallelFor(data.height(), [&](int y) {
    for (std::size_t i = static_cast<std::size_t>(y) * data.width(), end = i + data.width(); i < end; ++i) {
      if (!data.fitted.data()[i]) continue;
      SkinPoint p = problem_.PointAt(maps, i);
      FreeVector position = space.FromParameters(p);
      for (int j = 0; j < space.count(); ++j) position[j] += step.change[j].data()[i];
      space.ToParameters(position, p);
      SetPointAt(changed, i, p);
    }
  });
  return changed;
}

}  // namespace dermap
