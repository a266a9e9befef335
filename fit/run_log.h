// SPDX-License-Identifier: Apache-2.0
// The record that a method keeps while it runs: iterations, renders, time.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "fit/fit_result.h"
#include "fit/objective.h"
#include "fit/options.h"

namespace dermap {

class RunLog {
 public:
  explicit RunLog(ProgressFunction progress = {}, StopFunction stop = {})
      : start_(std::chrono::steady_clock::now()), progress_(std::move(progress)), stop_(std::move(stop)) {}

  double Seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  void Decide(std::string sentence) { decisions.push_back(std::move(sentence)); }
  // `renders` of the present size's problem; those of earlier sizes are in `renders_before`.
  void Add(const Misfit& misfit, int free_count, int renders) {
    history.push_back({static_cast<int>(history.size()), renders_before + renders, Seconds(), misfit.rms,
                       misfit.Chi2PerDegree(free_count)});
  }
  void Progress(double fraction) const {
    if (progress_) progress_(fraction);
  }
  // Whether a method is to end where it stands; once true it stays so.
  bool Stopped() const { return stop_ && stop_(); }

  std::vector<FitIteration> history;
  std::vector<std::string> decisions;
  int renders_before = 0;

 private:
  std::chrono::steady_clock::time_point start_;
  ProgressFunction progress_;
  StopFunction stop_;
};

}  // namespace dermap
