// SPDX-License-Identifier: Apache-2.0
// The callback that asks the log.
#include "fit/ceres_stop.h"

#include <ceres/iteration_callback.h>

namespace dermap {
namespace {

class Asking final : public ceres::IterationCallback {
 public:
  explicit Asking(const RunLog& log) : log_(log) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return log_.Stopped() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const RunLog& log_;
};

}  // namespace

std::unique_ptr<ceres::IterationCallback> StopWhenAsked(const RunLog& log) {
  return std::make_unique<Asking>(log);
}

}  // namespace dermap
