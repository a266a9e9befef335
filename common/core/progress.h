// SPDX-License-Identifier: Apache-2.0
// A progress bar with the time left, drawn on stderr when that is a terminal and silent otherwise.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace dermap {

// How far a long computation has come, 0 to 1; libraries call it, commands draw it. May be empty.
using ProgressFunction = std::function<void(double fraction)>;

class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ~ProgressBar();  // ends the line
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void Update(double fraction);
  ProgressFunction Function() {
    return [this](double fraction) { Update(fraction); };
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  bool on_terminal_;
  bool drawn_ = false;
  Clock::time_point start_;
  Clock::time_point last_draw_;
};

}  // namespace dermap
