// SPDX-License-Identifier: Apache-2.0
// Where descent and the reference start.
#pragma once

#include "fit/options.h"
#include "fit/patch_problem.h"
#include "fit/run_log.h"

namespace dermap {

// options.start, or the maps of the fit that is resumed; what is not free has the value of `fixed`. Says in
// the log which.
ParameterMaps StartMaps(const PatchProblem& problem, const SkinPoint& fixed, const FitOptions& options,
                        RunLog& log);

}  // namespace dermap
