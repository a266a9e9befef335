// SPDX-License-Identifier: Apache-2.0
// Coarse to fine.
#include "fit/fast.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "fit/local_start.h"
#include "fit/octave_solver.h"
#include "fit/resample.h"

namespace dermap {
namespace {

constexpr int kMaxSteps = 24;  // a size
// A size is done once a step moves the maps by less than this share of their standard deviations.
constexpr double kRest = 0.15, kCoarseRest = 0.4;
constexpr int kMostHalvings = 4;
constexpr double kWorse = 1.05, kAboveNoise = 1.5;  // chi2 of a step that went too far: over before, a datum

std::vector<int> Sizes(int size) {
  std::vector<int> sizes{size};
  while (sizes.back() % 2 == 0 && sizes.back() / 2 >= kCoarsestSize) sizes.push_back(sizes.back() / 2);
  std::reverse(sizes.begin(), sizes.end());
  return sizes;
}

// Skins from the patch's lightest to its darkest: means of the pixels around three quantiles of melanin.
std::vector<ParameterVector> SkinsOf(const PatchProblem& problem, const ParameterMaps& maps) {
  std::vector<std::pair<float, std::size_t>> by_melanin;
  for (std::size_t i = 0; i < problem.data().fitted.size(); ++i)
    if (problem.data().fitted.data()[i]) by_melanin.emplace_back(maps[Parameter::kC_m].data()[i], i);
  std::sort(by_melanin.begin(), by_melanin.end());
  std::vector<ParameterVector> skins;
  for (const double quantile : {0.02, 0.5, 0.98}) {
    const auto middle = static_cast<std::size_t>(quantile * static_cast<double>(by_melanin.size() - 1));
    const std::size_t reach = by_melanin.size() / 64;
    const std::size_t begin = middle - std::min(middle, reach);
    const std::size_t end = std::min(middle + reach + 1, by_melanin.size());
    ParameterVector mean{};
    for (std::size_t k = begin; k < end; ++k)
      for (int j = 0; j < kParameterCount; ++j)
        mean[j] += maps.planes[j].data()[by_melanin[k].second] / static_cast<double>(end - begin);
    skins.push_back(mean);
  }
  return skins;
}

// One size of the pyramid.
class SizeFit {
 public:
  SizeFit(PatchProblem& problem, DetailView detail, const SkinPoint& fixed)
      : problem_(problem), detail_(detail), fixed_(fixed) {}

  // Steps until the maps rest; true where they do.
  bool Refine(FitState& state, double rest, RunLog& log) {
    for (int step = 0; step < kMaxSteps; ++step) {
      const OctaveStep next = Estimate(state);
      Take(next, state);
      log.Add(state.misfit, problem_.space().count(), problem_.renders());
      if (next.move < rest) return true;
    }
    return false;
  }

  // What data and prior ask for at a state, the prior estimated on the way. Estimating takes a few passes
  // that cost no render; in large sizes, which begin with the estimates of smaller ones, one.
  OctaveStep Estimate(const FitState& state) {
    const std::vector<OctaveLevel> levels = LineariseInOctaves(problem_, state);
    const int passes = state.maps.width() <= 64 ? 4 : state.maps.width() <= 128 ? 2 : 1;
    OctaveStep step;
    for (int pass = 0; pass < passes; ++pass) {
      step = SolveInOctaves(problem_, levels, detail_, fixed_);
      Update(step.statistics, problem_.space().count(), detail_);
    }
    return step;
  }

 private:
  void Take(const OctaveStep& step, FitState& state) {
    const Misfit before = state.misfit;
    double share = 1.0;
    FitState next = problem_.StateOf(Apply(problem_, state.maps, step));
    for (int half = 0; half < kMostHalvings && next.misfit.chi2 > kWorse * before.chi2 &&
                       next.misfit.Chi2PerDatum() > kAboveNoise;
         ++half) {
      share *= 0.5;
      next = problem_.StateOf(Apply(problem_, state.maps, step, share));
    }
    state = std::move(next);
  }

  PatchProblem& problem_;
  DetailView detail_;
  SkinPoint fixed_;
};

}  // namespace

FastOutcome FitCoarseToFine(const FitData& data, const ForwardModel& model, const ParameterSpace& space,
                            const ModelMaker& make_model, const FitOptions& options, RunLog& log) {
  const std::vector<int> sizes = Sizes(std::max(data.width(), data.height()));
  const int octaves = static_cast<int>(OctaveShapes(data.width(), data.height()).size());
  const SkinPoint fixed = PointOf(options.fixed_values, model.tissue().junction_absorbance);
  FastOutcome outcome;
  std::optional<ParameterMaps> coarser;
  for (std::size_t s = 0; s < sizes.size(); ++s) {
    const bool finest = s + 1 == sizes.size();
    FitData reduced;
    std::optional<ForwardModel> coarse_model;
    if (!finest) {
      reduced = ReduceData(data, sizes[s], space.count());
      AddReductionError(reduced);
      coarse_model.emplace(make_model(reduced.conditions));
    }
    PatchProblem problem(finest ? data : reduced, finest ? model : *coarse_model, space);
    const int first = static_cast<int>(sizes.size() - 1 - s);  // octave of this size's pixels
    ParameterMaps start = coarser ? ResizeLinear(*coarser, problem.data().width(), problem.data().height())
                                  : InvertLocally(problem, options.fixed_values);
    if (!coarser)
      outcome.detail = FirstDetailModel(octaves, MeasureBlur(model, SkinsOf(problem, start), octaves - 1));
    const DetailView detail = ViewFrom(outcome.detail, first);
    for (int j = 0; coarser && j < space.count(); ++j)
      detail.prior[0][j] = GuessedVariance(detail.prior, 0, j);
    outcome.state = problem.StateOf(std::move(start));
    log.Add(outcome.state.misfit, space.count(), problem.renders());
    SizeFit fit(problem, detail, fixed);
    outcome.converged = fit.Refine(outcome.state, finest ? kRest : kCoarseRest, log);
    if (finest) {
      OctaveStep last = fit.Estimate(outcome.state);
      outcome.variance = std::move(last.variance);
      outcome.adapted_parameters = last.adapted_parameters;
    }
    coarser = outcome.state.maps;
    log.renders_before += problem.renders();
    log.Progress((s + 1.0) / static_cast<double>(sizes.size()));
  }
  return outcome;
}

}  // namespace dermap
