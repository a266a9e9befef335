// SPDX-License-Identifier: Apache-2.0
// Simultaneous descent: differences, a step in every pixel, one render to see who gained.
#include "fit/descent.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr int kRestWindow = 6;           // iterations over which the misfit is watched
constexpr double kRestFall = 5e-3;       // it is at rest once it fell by less than this share over the window
constexpr double kSmallReverted = 0.02;  // share of pixels that may rise without another render
constexpr double kPixelTolerance = 1e-3;  // chi2 of a pixel: rises below it are its neighbours' doing

// One pixel's equations from the forward differences: in reflectance for the plain gradient, which is the
// objective's own; in logarithms for the curvature, where a step reaches further.
PixelSystem SystemFromDifferences(const PatchProblem& problem, const FitState& state,
                                  const DerivativePlanes& derivatives, std::size_t pixel,
                                  DescentMetric metric) {
  const FitData& data = problem.data();
  PixelSystem system;
  system.count = problem.space().count();
  for (int b = 0; b < data.band_count(); ++b) {
    if (!data.Has(b, pixel)) continue;
    const double measured = data.measured[b].data()[pixel], sigma = data.sigma[b].data()[pixel];
    const double predicted = state.predicted[b].data()[pixel];
    double weight = 1.0 / sigma, residual = (measured - predicted) / sigma;
    if (metric == DescentMetric::kCurvature) {
      const LogResidual datum = LogResidualOf(measured, sigma, predicted);
      weight = datum.weight / std::max(predicted, 1e-7);
      residual = datum.residual;
    }
    FreeVector row{};
    for (int j = 0; j < system.count; ++j) row[j] = derivatives[j][b].data()[pixel] * weight;
    system.Add(row, residual);
  }
  return system;
}

// How far each pixel goes: for the plain gradient a factor on 1 / trace(J^T J), at which descent is sure in a
// linear problem; for the curvature a damping as a share of the mean of the diagonal.
class StepControl {
 public:
  StepControl(DescentMetric metric, int width, int height)
      : metric_(metric), length_(width, height, metric == DescentMetric::kPlain ? 1.0f : 1e-2f) {}

  FreeVector Step(const PixelSystem& system, std::size_t pixel, const FreeVector& position,
                  const ParameterSpace& space) const {
    const double length = length_.data()[pixel], trace = system.Trace();
    if (metric_ == DescentMetric::kCurvature)
      return BoundedStep(system, length * trace / system.count + 1.0, position, space.lower(), space.upper());
    FreeVector step{};
    for (int j = 0; j < system.count; ++j) {
      const double target = position[j] + (trace > 0.0 ? length / trace * system.rhs[j] : 0.0);
      step[j] = std::clamp(target, space.lower()[j], space.upper()[j]) - position[j];
    }
    return step;
  }
  void Shorten(std::size_t pixel) {
    float& length = length_.data()[pixel];
    length =
        metric_ == DescentMetric::kPlain ? std::max(length * 0.5f, 1e-3f) : std::min(length * 5.0f, 1e4f);
  }
  void Lengthen(std::size_t pixel) {
    float& length = length_.data()[pixel];
    length =
        metric_ == DescentMetric::kPlain ? std::min(length * 1.2f, 100.0f) : std::max(length * 0.3f, 1e-5f);
  }

 private:
  DescentMetric metric_;
  PlaneF length_;
};

ParameterMaps StepAll(const PatchProblem& problem, const FitState& state, const DerivativePlanes& derivatives,
                      const StepControl& control, DescentMetric metric) {
  const FitData& data = problem.data();
  const ParameterSpace& space = problem.space();
  ParameterMaps maps = state.maps;
  ParallelFor(data.height(), [&](int y) {
    for (int x = 0; x < data.width(); ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * data.width() + x;
      if (!data.fitted.data()[pixel]) continue;
      const PixelSystem system = SystemFromDifferences(problem, state, derivatives, pixel, metric);
      SkinPoint p = problem.PointAt(state.maps, pixel);
      FreeVector position = space.FromParameters(p);
      const FreeVector step = control.Step(system, pixel, position, space);
      for (int j = 0; j < space.count(); ++j) position[j] += step[j];
      space.ToParameters(position, p);
      SetPointAt(maps, pixel, p);
    }
  });
  return maps;
}

// Adapts each pixel's step length; returns how many pixels' chi2 rose, and their maps as they were before.
std::size_t KeepGains(const FitState& before, const FitState& trial, StepControl& control,
                      ParameterMaps& mixed) {
  std::size_t risen = 0;
  mixed = trial.maps;
  for (std::size_t i = 0; i < before.misfit.chi2_map.size(); ++i) {
    const double old_chi2 = before.misfit.chi2_map.data()[i], new_chi2 = trial.misfit.chi2_map.data()[i];
    if (new_chi2 <= old_chi2 * (1.0 + kPixelTolerance) + kPixelTolerance) {
      control.Lengthen(i);
      continue;
    }
    control.Shorten(i);
    SetPointAt(mixed, i, PointAt(before.maps, i, 0.0));
    ++risen;
  }
  return risen;
}

// One step from `state`; false (and the state unchanged) where nothing lowered the misfit of the whole.
bool Advance(PatchProblem& problem, FitState& state, const DerivativePlanes& derivatives,
             StepControl& control, DescentMetric metric) {
  FitState trial = problem.StateOf(StepAll(problem, state, derivatives, control, metric));
  ParameterMaps mixed;
  const std::size_t risen = KeepGains(state, trial, control, mixed);
  const double share = static_cast<double>(risen) / static_cast<double>(problem.data().fitted.size());
  if (risen > 0 && (share > kSmallReverted || trial.misfit.chi2 >= state.misfit.chi2)) {
    FitState without_losers = problem.StateOf(std::move(mixed));
    if (without_losers.misfit.chi2 < trial.misfit.chi2) trial = std::move(without_losers);
  }
  if (trial.misfit.chi2 >= state.misfit.chi2) {
    for (std::size_t i = 0; i < problem.data().fitted.size(); ++i) control.Shorten(i);
    return false;
  }
  state = std::move(trial);
  return true;
}

bool AtRest(const std::vector<FitIteration>& history, std::size_t first) {
  if (history.size() < first + kRestWindow + 1) return false;
  const double before = history[history.size() - 1 - kRestWindow].chi2, now = history.back().chi2;
  return before - now < kRestFall * before;
}

void Say(RunLog& log, const char* format, double value) {
  char text[160];
  std::snprintf(text, sizeof text, format, value);
  log.Decide(text);
}

}  // namespace

DescentOutcome Descend(PatchProblem& problem, ParameterMaps start, const FitOptions& options, RunLog& log) {
  DescentOutcome outcome{problem.StateOf(std::move(start)), false};
  FitState& state = outcome.state;
  StepControl control(options.metric, problem.data().width(), problem.data().height());
  const std::size_t first = log.history.size();
  log.Add(state.misfit, problem.space().count(), problem.renders());
  Say(log, "Forward differences step by %g of a parameter's scale (range / sqrt 12).",
      options.difference_step);
  DerivativePlanes derivatives;
  bool moved = true;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    if (state.misfit.Chi2PerDegree(problem.space().count()) <= options.stop_chi2) {
      Say(log, "Stopped at the noise: chi2 per degree of freedom is at or below %g.", options.stop_chi2);
      outcome.converged = true;
      return outcome;
    }
    if (AtRest(log.history, first)) {
      Say(log, "Stopped at rest: chi2 fell by less than %g %% over six iterations.", 100.0 * kRestFall);
      outcome.converged = true;
      return outcome;
    }
    if (log.Stopped()) return outcome;
    if (moved) derivatives = problem.ForwardDifferences(state, options.difference_step);
    moved = Advance(problem, state, derivatives, control, options.metric);
    log.Add(state.misfit, problem.space().count(), problem.renders());
    log.Progress((iteration + 1.0) / options.max_iterations);
  }
  Say(log, "Stopped after the %g iterations allowed, still falling.", options.max_iterations);
  return outcome;
}

}  // namespace dermap
