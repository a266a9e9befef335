// SPDX-License-Identifier: Apache-2.0
// Coarse to fine Gauss-Newton in octaves of detail.
#include "fit/fast.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

#include "fit/local_start.h"
#include "fit/resample.h"

namespace dermap {
namespace {

constexpr int kMaxSteps = 24;  // a size

std::vector<int> Sizes(int size) {
  std::vector<int> sizes{size};
  while (sizes.back() % 2 == 0 && sizes.back() / 2 >= kCoarsestSize) sizes.push_back(sizes.back() / 2);
  std::reverse(sizes.begin(), sizes.end());
  return sizes;
}

// Skins from the patch's lightest to its darkest, by melanin: means of the pixels around the quantiles.
std::vector<ParameterVector> SkinsOf(const PatchProblem& problem, const ParameterMaps& maps) {
  std::vector<std::pair<float, std::size_t>> by_melanin;
  for (std::size_t i = 0; i < problem.data().fitted.size(); ++i)
    if (problem.data().fitted.data()[i]) by_melanin.emplace_back(maps[Parameter::kC_m].data()[i], i);
  std::sort(by_melanin.begin(), by_melanin.end());
  std::vector<ParameterVector> skins;
  for (const double quantile : {0.02, 0.5, 0.98}) {
    const std::size_t middle = static_cast<std::size_t>(quantile * static_cast<double>(by_melanin.size() - 1));
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

}  // namespace

FastOutcome FitCoarseToFine(const FitData& data, const ForwardModel& model, const ParameterSpace& space,
                            const ModelMaker& make_model, const FitOptions& options, RunLog& log) {
  const std::vector<int> sizes = Sizes(std::max(data.width(), data.height()));
  const int octaves = static_cast<int>(OctaveShapes(data.width(), data.height()).size());
  FastOutcome outcome;
  outcome.prior = FirstPrior(octaves);
  outcome.scatter.assign(octaves, 1.0);
  std::optional<ParameterMaps> coarser;
  const bool talk = std::getenv("TALK");
  for (std::size_t level = 0; level < sizes.size(); ++level) {
    const bool finest = level + 1 == sizes.size();
    const int first = static_cast<int>(sizes.size() - 1 - level);  // octave of this size's pixels
    FitData reduced;
    std::optional<ForwardModel> coarse_model;
    if (!finest) {
      reduced = ReduceData(data, sizes[level], space.count());
      AddReductionError(reduced);
      coarse_model.emplace(make_model(reduced.conditions));
    }
    PatchProblem problem(finest ? data : reduced, finest ? model : *coarse_model, space);
    ParameterMaps start = coarser ? ResizeLinear(*coarser, problem.data().width(), problem.data().height())
                                  : InvertLocally(problem, options.fixed_values);
    if (!coarser) {
      outcome.blur = MeasureBlur(model, SkinsOf(problem, start), octaves - 1);
      if (talk) printf("%.2fs after shares\n", log.Seconds());
    }
    FitState& state = outcome.state;
    state = problem.StateOf(std::move(start));
    log.Add(state.misfit, space.count(), problem.renders());
    OctaveModel octave_model(problem, std::span<const std::vector<BlurCurve>>(outcome.blur).subspan(first), options.fixed_values);
    const std::span<FreeVector> prior = std::span(outcome.prior).subspan(first);
    outcome.converged = false;
    if (coarser) for (int j = 0; j < space.count(); ++j) prior[0][j] = 0.5 * prior[1][j];
    const std::span<double> scatter = std::span(outcome.scatter).subspan(first);
    const char* pp = std::getenv("PASS"); const int passes = pp ? atoi(pp) : sizes[level] <= 64 ? 4 : finest ? 1 : 2;
    const char* e = std::getenv(finest ? "REST" : "RESTC");
    const double rest = e ? atof(e) : finest ? 0.1 : 0.3;
    for (int step = 0; step < kMaxSteps && !outcome.converged; ++step) {
      octave_model.Linearise(state);
      const double t0 = log.Seconds();
      OctaveStep solution;
      for (int pass = 0; pass < passes; ++pass) {
        solution = octave_model.Solve(prior, scatter);
        std::copy(solution.next_prior.begin(), solution.next_prior.end(), prior.begin());
        std::copy(solution.next_scatter.begin(), solution.next_scatter.end(), scatter.begin());
      }
      const double t1 = log.Seconds();
      const double before = state.misfit.chi2 + solution.prior_misfit;
      FitState next = problem.StateOf(octave_model.Apply(state.maps, solution));
      for (int half = 0; half < 4 && next.misfit.chi2 > 1.05 * state.misfit.chi2 && next.misfit.Chi2PerDatum() > 1.5; ++half) {
        if (talk) printf("halved from %g to %g\n", state.misfit.Chi2PerDatum(), next.misfit.Chi2PerDatum());
        for (PlaneF& change : solution.change) for (float& v : change.values()) v *= 0.5f;
        next = problem.StateOf(octave_model.Apply(state.maps, solution));
      }
      state = std::move(next);
      if (talk) printf("size %d step %d: chi2/datum %.4f objective before %.1f move %.3f adapted %.3f solve %.3f all %.3f\n", sizes[level], step, state.misfit.Chi2PerDatum(), before, solution.move, solution.adapted_parameters / state.misfit.pixel_count, t1 - t0, log.Seconds()-t0);
      log.Add(state.misfit, space.count(), problem.renders());
      outcome.converged = solution.move < rest;
    }
    if (talk) for (std::size_t l = 0; l < prior.size(); ++l) { printf(" prior %zu:", l); for (int j = 0; j < space.count(); ++j) printf(" %.5f", std::sqrt(prior[l][j])); printf("\n"); }
    if (finest) {
      octave_model.Linearise(state);
      OctaveStep solution = octave_model.Solve(prior, scatter);
      outcome.variance = std::move(solution.variance);
      outcome.adapted_parameters = solution.adapted_parameters;
    }
    coarser = state.maps;
    log.renders_before += problem.renders();
    log.Progress((level + 1.0) / static_cast<double>(sizes.size()));
  }
  return outcome;
}

}  // namespace dermap
