// SPDX-License-Identifier: Apache-2.0
// Estimate, step, render.
#include "fit/size_fit.h"

#include <utility>
#include <vector>

namespace dermap {
namespace {

constexpr int kMaxSteps = 24;
constexpr int kMostHalvings = 4;
// A step went too far where chi2 grew by this factor and is above that a datum.
constexpr double kWorse = 1.05, kAboveNoise = 1.5;

}  // namespace

bool SizeFit::Refine(FitState& state, double rest, RunLog& log, OctaveStep& last) {
  for (int step = 0; step < kMaxSteps; ++step) {
    last = Estimate(state);
    if (log.Stopped()) return false;
    Take(last, state);
    log.Add(state.misfit, problem_.space().count(), problem_.renders());
    if (last.move < rest) return true;
  }
  return false;
}

// The prior is estimated on the way: a few passes that cost no render; in large sizes, which begin with the
// estimates of smaller ones, one.
OctaveStep SizeFit::Estimate(const FitState& state) {
  const std::vector<OctaveLevel> levels = LineariseInOctaves(problem_, state);
  const int passes = state.maps.width() <= 32 ? 4 : state.maps.width() <= 64 ? 2 : 1;
  OctaveStep step;
  for (int pass = 0; pass < passes; ++pass) {
    step = SolveInOctaves(problem_, levels, detail_, fixed_);
    Update(step.statistics, problem_.space().count(), detail_);
  }
  return step;
}

void SizeFit::Take(const OctaveStep& step, FitState& state) {
  double share = 1.0;
  FitState next = problem_.StateOf(Apply(problem_, state.maps, step));
  for (int half = 0; half < kMostHalvings && next.misfit.chi2 > kWorse * state.misfit.chi2 &&
                     next.misfit.Chi2PerDatum() > kAboveNoise;
       ++half) {
    share *= 0.5;
    next = problem_.StateOf(Apply(problem_, state.maps, step, share));
  }
  state = std::move(next);
}

}  // namespace dermap
