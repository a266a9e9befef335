// SPDX-License-Identifier: Apache-2.0
// Ends Ceres's solvers between iterations, with the best point so far.
#pragma once

#include <ceres/iteration_callback.h>

#include "fit/run_log.h"

namespace dermap {

class StopWhenAsked final : public ceres::IterationCallback {
 public:
  explicit StopWhenAsked(const RunLog& log) : log_(log) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return log_.Stopped() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const RunLog& log_;
};

}  // namespace dermap
