// SPDX-License-Identifier: Apache-2.0
// From the mean to the finest detail.
#include "fit/octave_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/core/parallel.h"
#include "fit/small_system.h"

namespace dermap {
namespace {

std::vector<PlaneF> Zeros(std::size_t count, GridShape shape) {
  return std::vector<PlaneF>(count, PlaneF(shape.width, shape.height));
}

void DoubleAll(std::vector<PlaneF>& planes, GridShape shape) {
  ParallelFor(static_cast<int>(planes.size()), [&](int i) { planes[i] = Double(planes[i], shape); });
}

void AddAll(const std::vector<PlaneF>& add, std::vector<PlaneF>& sum) {
  for (std::size_t p = 0; p < sum.size(); ++p)
    for (std::size_t i = 0; i < sum[p].size(); ++i) sum[p].data()[i] += add[p].data()[i];
}

// What the octaves so far have changed, brought to the grid of the next.
struct Sofar {
  std::vector<PlaneF> change, variance;     // [free parameter]
  std::vector<PlaneF> answered, unblurred;  // [band], what the change does to the logarithms

  void Double(GridShape shape) {
    for (std::vector<PlaneF>* planes : {&change, &answered, &unblurred}) DoubleAll(*planes, shape);
    for (PlaneF& plane : variance) plane = Interpolate(plane, shape);  // never below 0
  }
};

// Of the finest octave one of so many pairs of rows is looked at for how far residuals scatter.
constexpr int kSampledRows = 4;

// One octave's system in every pixel.
class LevelSolver {
 public:
  LevelSolver(const PatchProblem& problem, const std::vector<OctaveLevel>& levels, int index,
              const DetailView& model, const SkinPoint& fixed)
      : problem_(problem),
        level_(levels[index]),
        prior_(model.prior[index]),
        details_(model.details[index]),
        link_(model.link),
        top_(index + 1 == static_cast<int>(levels.size())),
        every_(index == 0 ? kSampledRows : 1),
        maker_(problem, level_, top_ ? nullptr : BlurOf(model, index), fixed),
        share_(top_ ? 1.0 : kDetailShare),
        noise_(level_.noise_inflation * model.scatter[index]) {
    for (const Parameter p : problem.space().free()) {
      activity_.push_back(model.ActivityOf(index, level_.shape, p));
      pigment_.push_back(static_cast<std::size_t>(PigmentOf(p)));
    }
  }

  DetailStatistics Solve(Sofar& sofar) {
    const int count = problem_.space().count();
    change_ = variance_ = Zeros(count, level_.shape);
    for (const std::size_t p : pigment_) told_[p] = PlaneF(level_.shape.width, level_.shape.height);
    std::vector<FreeVector> determined(level_.shape.height, FreeVector{});  // by row
    ForEachPixel([&](int y, std::size_t i, std::span<OctaveRow> rows) {
      switch (count) {
        case 1:
          return SolvePixel<1>(i, rows, sofar, determined[y]);
        case 2:
          return SolvePixel<2>(i, rows, sofar, determined[y]);
        case 3:
          return SolvePixel<3>(i, rows, sofar, determined[y]);
        case 4:
          return SolvePixel<4>(i, rows, sofar, determined[y]);
        case 5:
          return SolvePixel<5>(i, rows, sofar, determined[y]);
        default:
          return SolvePixel<kUnknownCount>(i, rows, sofar, determined[y]);
      }
    });
    if (!top_) ParallelFor(count, [&](int j) { change_[j] = DetailOf(change_[j]); });
    AddAll(change_, sofar.change);
    AddAll(variance_, sofar.variance);
    ForEachPixel([&](int, std::size_t i, std::span<OctaveRow> rows) { Answer(i, rows, sofar); }, every_);
    return Statistics(determined, sofar);
  }

 private:
  // Pairs of rows, one of `every` of them.
  template <class Body>
  void ForEachPixel(const Body& body, int every = 1) const {
    ParallelFor(level_.shape.height, [&](int y) {
      if (y / 2 % every != 0) return;
      std::vector<OctaveRow> rows(level_.weight.size());
      const std::size_t begin = static_cast<std::size_t>(y) * level_.shape.width;
      for (std::size_t i = begin; i < begin + level_.shape.width; ++i) {
        maker_.Fill(i, rows);
        body(y, i, std::span(rows));
      }
    });
  }

  template <int N>
  void SolvePixel(std::size_t i, std::span<const OctaveRow> rows, Sofar& sofar, FreeVector& determined) {
    const ParameterSpace& space = problem_.space();
    SmallSystem<N> system;
    for (std::size_t b = 0; b < rows.size(); ++b) {
      // What coarser changes do here differs from what they do on average: where there is more melanin, a
      // change of its kind does more.
      float answer = 0.0f;
      for (int j = 0; j < N; ++j) answer += rows[b].unblurred[j] * sofar.change[j].data()[i];
      float& answered = sofar.answered[b].data()[i];
      answered += rows[b].epidermis_share * (answer - sofar.unblurred[b].data()[i]);
      system.Add(rows[b].blurred, level_.residual[b].data()[i] - answered,
                 level_.weight[b].data()[i] / noise_);
    }
    FreeVector lower, upper, change, variance;
    for (int j = 0; j < N; ++j) {
      const double position = level_.position[j].data()[i] + sofar.change[j].data()[i];
      lower[j] = std::min(space.lower()[j] - position, 0.0);
      upper[j] = std::max(space.upper()[j] - position, 0.0);
      if (!link_) system.AddPrior(j, PrecisionAt(i, j), -level_.detail[j].data()[i]);
    }
    if (link_) AddLink(i, system);
    system.Solve(lower, upper, change, variance);
    for (int j = 0; j < N; ++j) {
      change_[j].data()[i] = static_cast<float>(change[j]);
      variance_[j].data()[i] =
          static_cast<float>(share_ * (variance[j] + VarianceOfShrinking(i, j, change[j], variance[j])));
      if (link_) continue;
      const double told = 1.0 - variance[j] * PrecisionAt(i, j);
      determined[j] += told;
      told_[pigment_[j]].data()[i] += static_cast<float>(told);
    }
    if (!link_) return;
    const double decided = N - LinkFactor() * system.InverseTimes(LinkPrecision());
    for (int j = 0; j < N; ++j) determined[j] += decided / N;
  }

  double ActivityAt(std::size_t i, int j) const { return activity_[j] ? activity_[j]->data()[i] : 1.0; }
  double PrecisionAt(std::size_t i, int j) const { return share_ / (prior_[j] * ActivityAt(i, j)); }

  // A detail is drawn towards nothing as far as the data leave it open, by a variance that is itself an
  // estimate from a number of details: its relative variance is 2 over that.
  double VarianceOfShrinking(std::size_t i, int j, double change, double variance) const {
    if (top_ || link_ || details_[j] <= 0.0) return 0.0;
    const double open = std::min(variance * PrecisionAt(i, j), 1.0);
    const double shrunk = open * (level_.detail[j].data()[i] + change);
    return 2.0 / details_[j] * shrunk * shrunk;
  }

  // What earlier fits say, as a quadratic form of the mean's distance or of the detail.
  const FreeMatrix& LinkPrecision() const { return top_ ? link_->mean_precision : link_->detail_precision; }
  double LinkFactor() const { return top_ ? 1.0 : share_ * link_->detail_variance[0] / prior_[0]; }
  template <int N>
  void AddLink(std::size_t i, SmallSystem<N>& system) const {
    FreeVector center{};
    for (int j = 0; j < N; ++j) {
      center[j] = -level_.detail[j].data()[i];
      if (top_) center[j] += link_->mean[j] - problem_.space().mean()[j];
    }
    system.AddPrior(LinkPrecision(), LinkFactor(), center);
  }
  // Sum over the pixels of the details' squares over their covariance in earlier fits.
  double LinkedSquares() const {
    double sum = 0.0;
    for (std::size_t j = 0; j < change_.size(); ++j)
      for (std::size_t k = 0; k < change_.size(); ++k)
        for (std::size_t i = 0; i < level_.shape.size(); ++i)
          sum += link_->detail_precision[j][k] *
                 (static_cast<double>(level_.detail[j].data()[i]) + change_[j].data()[i]) *
                 (static_cast<double>(level_.detail[k].data()[i]) + change_[k].data()[i]);
    return sum;
  }

  void Answer(std::size_t i, std::span<const OctaveRow> rows, Sofar& sofar) const {
    for (std::size_t b = 0; b < rows.size(); ++b) {
      float answer = 0.0f, unblurred = 0.0f;
      for (std::size_t j = 0; j < change_.size(); ++j) {
        answer += rows[b].blurred[j] * change_[j].data()[i];
        unblurred += rows[b].unblurred[j] * sofar.change[j].data()[i];
      }
      sofar.answered[b].data()[i] += answer;
      sofar.unblurred[b].data()[i] = unblurred;
    }
  }

  DetailStatistics Statistics(const std::vector<FreeVector>& determined, const Sofar& sofar) const {
    DetailStatistics statistics;
    statistics.pixels = static_cast<double>(level_.shape.size());
    for (const std::size_t p : pigment_)
      statistics.energy[p] = PlaneF(level_.shape.width, level_.shape.height);
    statistics.told = told_;
    double adapted = 0.0;
    for (std::size_t j = 0; j < change_.size(); ++j) {
      for (std::size_t i = 0; i < level_.shape.size(); ++i) {
        const double detail = static_cast<double>(level_.detail[j].data()[i]) + change_[j].data()[i];
        statistics.squares[j] += detail * detail / ActivityAt(i, static_cast<int>(j));
        statistics.energy[pigment_[j]].data()[i] += static_cast<float>(detail * detail / prior_[j]);
      }
      for (const FreeVector& row : determined) statistics.determined[j] += row[j];
      adapted += share_ * statistics.determined[j];
    }
    if (link_) statistics.linked_squares = LinkedSquares();
    if (top_) statistics.noise_share = NoiseShare();
    AddResiduals(sofar, statistics);
    statistics.residual_count = std::max(statistics.residual_count - adapted, 0.0);
    return statistics;
  }

  // Of the mean's variance, over the bands.
  double NoiseShare() const {
    const double shared = level_.shared_error * level_.shared_error / level_.noise_inflation;
    double share = 0.0;
    for (const PlaneF& weight : level_.weight) share += 1.0 - shared * weight.data()[0];
    return std::max(share / static_cast<double>(level_.weight.size()), 0.0);
  }

  // What stays unanswered, by its distance from the mean of 2 x 2 pixels. The rows that Answer() saw stand
  // for all.
  void AddResiduals(const Sofar& sofar, DetailStatistics& statistics) const {
    const int width = level_.shape.width, height = level_.shape.height;
    std::vector<std::array<double, 2>> of_band(level_.residual.size());
    std::size_t seen_rows = 0;
    for (int y = 0; y < height; ++y) seen_rows += y / 2 % every_ == 0;
    ParallelFor(static_cast<int>(of_band.size()), [&](int b) {
      for (int y = 0; y < height; y += 2 * every_)
        for (int x = 0; x < width; x += 2) {
          const auto [squares, count] = BlockResidual(b, x, y, sofar.answered[b]);
          of_band[b][0] += squares;
          of_band[b][1] += count;
        }
    });
    const double all = static_cast<double>(height) / static_cast<double>(seen_rows);
    for (const auto& [squares, count] : of_band) {
      statistics.residual_squares += all * squares;
      statistics.residual_count += all * count;
    }
  }

  // Sum of squares over noise of 2 x 2 pixels (fewer at a border) about their mean, and its expectation.
  std::array<double, 2> BlockResidual(int band, int x, int y, const PlaneF& answered) const {
    double weights = 0.0, sum = 0.0, squares = 0.0;
    int count = 0;
    for (int v = y; v < std::min(y + 2, level_.shape.height); ++v)
      for (int u = x; u < std::min(x + 2, level_.shape.width); ++u) {
        const double weight = level_.weight[band](u, v) / level_.noise_inflation;
        if (weight <= 0.0) continue;
        const double left = static_cast<double>(level_.residual[band](u, v)) - answered(u, v);
        weights += weight;
        sum += weight * left;
        squares += weight * left * left;
        ++count;
      }
    if (count == 0) return {0.0, 0.0};
    return top_ ? std::array{squares, 1.0 * count}
                : std::array{std::max(squares - sum * sum / weights, 0.0), count - 1.0};
  }

  const PatchProblem& problem_;
  const OctaveLevel& level_;
  const FreeVector& prior_;
  const FreeVector& details_;
  const LinkedPrior* link_;  // null: none
  bool top_;
  int every_;  // so-many-th pair of rows is answered
  RowMaker maker_;
  double share_;  // of the pixels' dimensions that this octave's details span
  double noise_;  // variance of the noise over what `weight` says
  std::vector<PlaneF> change_, variance_;
  std::vector<const PlaneF*> activity_;     // [free parameter]; null: 1 everywhere
  std::vector<std::size_t> pigment_;        // likewise
  std::array<PlaneF, kPigmentCount> told_;  // how much of its parameters the data decide
};

}  // namespace

OctaveStep SolveInOctaves(const PatchProblem& problem, const std::vector<OctaveLevel>& levels,
                          const DetailView& model, const SkinPoint& fixed) {
  const int count = problem.space().count(), top = static_cast<int>(levels.size()) - 1;
  const std::size_t bands = problem.data().bands.size();
  const GridShape whole = levels[top].shape;
  Sofar sofar{Zeros(count, whole), Zeros(count, whole), Zeros(bands, whole), Zeros(bands, whole)};
  OctaveStep step;
  step.statistics.resize(levels.size());
  for (int l = top; l >= 0; --l) {
    if (l < top) sofar.Double(levels[l].shape);
    step.statistics[l] = LevelSolver(problem, levels, l, model, fixed).Solve(sofar);
    for (int j = 0; j < count; ++j)
      step.adapted_parameters += (l == top ? 1.0 : kDetailShare) * step.statistics[l].determined[j];
  }
  step.change = std::move(sofar.change);
  step.variance = std::move(sofar.variance);
  double squares = 0.0;
  for (int j = 0; j < count; ++j)
    for (std::size_t i = 0; i < step.change[j].size(); ++i) {
      squares += step.change[j].data()[i] * step.change[j].data()[i] / step.variance[j].data()[i];
    }
  step.move = std::sqrt(squares / (count * static_cast<double>(levels[0].shape.size())));
  return step;
}

ParameterMaps Apply(const PatchProblem& problem, const ParameterMaps& maps, const OctaveStep& step,
                    double share) {
  const FitData& data = problem.data();
  const ParameterSpace& space = problem.space();
  ParameterMaps changed = maps;
  ParallelFor(data.height(), [&](int y) {
    const std::size_t begin = static_cast<std::size_t>(y) * data.width();
    for (std::size_t i = begin; i < begin + data.width(); ++i) {
      if (!data.fitted.data()[i]) continue;
      SkinPoint p = problem.PointAt(maps, i);
      FreeVector position = space.FromParameters(p);
      for (int j = 0; j < space.count(); ++j) position[j] += share * step.change[j].data()[i];
      space.ToParameters(position, p);
      SetPointAt(changed, i, p);
    }
  });
  return changed;
}

}  // namespace dermap
