// SPDX-License-Identifier: Apache-2.0
// The published fit: descent simultaneously in all pixels, from forward differences of the full render
// [D08 6.3].
#pragma once

#include "fit/options.h"
#include "fit/patch_problem.h"
#include "fit/run_log.h"

namespace dermap {

struct DescentOutcome {
  FitState state;
  bool converged = false;  // reached the noise, or came to rest
};

// From `start` until chi2 per degree of freedom is options.stop_chi2, the misfit comes to rest, or
// options.max_iterations. The misfit never rises from one iteration of the log to the next. Each pixel has a
// step length of its own, which shrinks when its chi2 rose (and the pixel goes back) and grows when it fell.
// [D08] does not say how its steps are chosen.
DescentOutcome Descend(PatchProblem& problem, ParameterMaps start, const FitOptions& options, RunLog& log);

}  // namespace dermap
