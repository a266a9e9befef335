// SPDX-License-Identifier: Apache-2.0
// Coarse to fine Gauss-Newton.
#include "fit/fast.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <utility>

#include "common/core/parallel.h"
#include "fit/local_start.h"
#include "fit/resample.h"

namespace dermap {
namespace {

constexpr int kMaxStepsPerSize = 24;
constexpr double kRestFall = 0.02;  // a size is done once a step lowers its misfit by less than this share
constexpr double kRangePrecision = 1.0;  // of average skin, scaled units: the variance of table 1's range
constexpr double kFirstDamping = 1e-3;   // share of the mean of a pixel's diagonal

// A step in every pixel: data, range prior, and the coarser solution as a prior where there is one.
ParameterMaps StepAll(const PatchProblem& problem, const FitState& state, const ParameterMaps* coarser,
                      double damping) {
  const FitData& data = problem.data();
  const ParameterSpace& space = problem.space();
  ParameterMaps maps = state.maps;
  ParallelFor(data.height(), [&](int y) {
    for (int x = 0; x < data.width(); ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * data.width() + x;
      if (!data.fitted.data()[pixel]) continue;
      ParameterVector p = ParametersAt(state.maps, pixel);
      FreeVector position = space.FromParameters(p), center = space.mean();
      PixelSystem system = LocalSystem(problem, pixel, p, &state.predicted);
      const double data_trace = system.Trace();
      if (coarser) center = space.FromParameters(ParametersAt(*coarser, pixel));
      const double precision = coarser ? 1.0 / (kDetailSigma * kDetailSigma) : kRangePrecision;
      for (int j = 0; j < space.count(); ++j) system.AddPrior(j, precision, center[j], position[j]);
      const FreeVector step =
          BoundedStep(system, damping * data_trace / space.count(), position, space.lower(), space.upper());
      for (int j = 0; j < space.count(); ++j) position[j] += step[j];
      space.ToParameters(position, p);
      SetParametersAt(maps, pixel, p);
    }
  });
  return maps;
}

// Iterates one size, `forced` steps if there is such a number; true where it came to rest or to the noise.
bool Refine(PatchProblem& problem, FitState& state, const ParameterMaps* coarser, const FitOptions& options,
            std::optional<int> forced, RunLog& log, int& step) {
  double damping = kFirstDamping;
  for (step = 0; step < forced.value_or(kMaxStepsPerSize); ++step) {
    if (!forced && state.misfit.Chi2PerDegree(problem.space().count()) <= options.stop_chi2) return true;
    FitState next = problem.StateOf(StepAll(problem, state, coarser, damping));
    const double fall = 1.0 - next.misfit.chi2 / state.misfit.chi2;
    if (fall > 0.0 || forced) {
      state = std::move(next);
      damping *= 0.3;
    } else {
      damping = std::max(damping, 1e-2) * 10.0;
    }
    log.Add(state.misfit, problem.space().count(), problem.renders());
    if (!forced && std::abs(fall) < kRestFall) {
      ++step;
      return true;
    }
  }
  return false;
}

std::vector<int> Sizes(int size) {
  std::vector<int> sizes{size};
  while (sizes.back() % 2 == 0 && sizes.back() / 2 >= kCoarsestSize) sizes.push_back(sizes.back() / 2);
  std::reverse(sizes.begin(), sizes.end());
  return sizes;
}

}  // namespace

FastOutcome FitCoarseToFine(const FitData& data, const ForwardModel& model, const ParameterSpace& space,
                            const ModelMaker& make_model, const FitOptions& options, RunLog& log,
                            const std::vector<int>* steps) {
  const std::vector<int> sizes = Sizes(std::max(data.width(), data.height()));
  FastOutcome outcome;
  std::optional<ParameterMaps> coarser;
  for (std::size_t level = 0; level < sizes.size(); ++level) {
    const bool finest = level + 1 == sizes.size();
    FitData reduced;
    std::optional<ForwardModel> coarse_model;
    if (!finest) {
      reduced = ReduceData(data, sizes[level], space.count());
      AddReductionError(reduced);
      coarse_model.emplace(make_model(reduced.conditions));
    }
    PatchProblem problem(finest ? data : reduced, finest ? model : *coarse_model, space);
    if (coarser) coarser = ResizeLinear(*coarser, problem.data().width(), problem.data().height());
    ParameterMaps start = coarser ? *coarser : InvertLocally(problem, options.fixed_values);
    outcome.state = problem.StateOf(std::move(start));
    log.Add(outcome.state.misfit, space.count(), problem.renders());
    const std::optional<int> forced = steps ? std::optional<int>((*steps)[level]) : std::nullopt;
    outcome.steps.push_back(0);
    outcome.converged = Refine(problem, outcome.state, coarser ? &*coarser : nullptr, options, forced, log,
                               outcome.steps.back());
    coarser = outcome.state.maps;
    log.renders_before += problem.renders();
    log.Progress((level + 1.0) / static_cast<double>(sizes.size()));
  }
  return outcome;
}

double AdaptedParameters(const FitData& data, const ForwardModel& model, const ParameterSpace& space,
                         const ModelMaker& make_model, const FitOptions& options, const FastOutcome& outcome,
                         RunLog& log) {
  constexpr double kProbe_sigma = 0.5;
  std::mt19937_64 random(options.seed);
  FitData probed = data;
  std::vector<std::vector<signed char>> signs(data.bands.size());
  for (int b = 0; b < data.band_count(); ++b) {
    for (std::size_t i = 0; i < data.fitted.size(); ++i) {
      signs[b].push_back(random() >> 63 ? 1 : -1);
      probed.measured[b].data()[i] +=
          static_cast<float>(kProbe_sigma * signs[b][i] * data.sigma[b].data()[i]);
    }
  }
  RunLog probe_log;
  const FastOutcome probe =
      FitCoarseToFine(probed, model, space, make_model, options, probe_log, &outcome.steps);
  log.renders_before += probe_log.renders_before;
  double sum = 0.0;
  for (int b = 0; b < data.band_count(); ++b) {
    for (std::size_t i = 0; i < data.fitted.size(); ++i) {
      if (!data.fitted.data()[i] || !data.Has(b, i)) continue;
      const double change =
          static_cast<double>(probe.state.predicted[b].data()[i]) - outcome.state.predicted[b].data()[i];
      sum += signs[b][i] * change / (kProbe_sigma * data.sigma[b].data()[i]);
    }
  }
  return sum;
}

}  // namespace dermap
