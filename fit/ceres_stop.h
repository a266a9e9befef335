// SPDX-License-Identifier: Apache-2.0
// Ends Ceres's solvers between iterations, with the best point so far.
#pragma once

#include <memory>

#include "fit/run_log.h"

namespace ceres {
class IterationCallback;
}

namespace dermap {

// For a solver's callbacks; borrows the log. Whoever calls it includes <ceres/iteration_callback.h>.
std::unique_ptr<ceres::IterationCallback> StopWhenAsked(const RunLog& log);

}  // namespace dermap
