// SPDX-License-Identifier: Apache-2.0
// Steps at one size: what data and prior ask for (fit/octave_solver.h), and the render that says what is
// left.
#pragma once

#include "fit/octave_solver.h"
#include "fit/patch_problem.h"
#include "fit/run_log.h"

namespace dermap {

class SizeFit {
 public:
  // Borrows the problem and what `detail` sees.
  SizeFit(PatchProblem& problem, const DetailView& detail, const SkinPoint& fixed)
      : problem_(problem), detail_(detail), fixed_(fixed) {}

  // Steps until one moves the maps by less than `rest` of their standard deviations; true where they come to
  // it. `last` is the last step; one that was not taken where the log is stopped.
  bool Refine(FitState& state, double rest, RunLog& log, OctaveStep& last);

 private:
  OctaveStep Estimate(const FitState& state);
  void Take(const OctaveStep& step, FitState& state);

  PatchProblem& problem_;
  DetailView detail_;
  SkinPoint fixed_;
};

}  // namespace dermap
