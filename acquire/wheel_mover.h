// SPDX-License-Identifier: Apache-2.0
// Moves the wheel ahead of time, beside whatever else is going on, and waits for it where a frame needs it.
#pragma once

#include <future>

#include "acquire/devices/filter_wheel.h"
#include "acquire/timeline.h"

namespace dermap {

class WheelMover {
 public:
  WheelMover(FilterWheel& wheel, const Stopwatch& stopwatch) : wheel_(wheel), stopwatch_(stopwatch) {}
  ~WheelMover();  // lets a move come to its end
  // Begins a move; nothing where one is under way already, or a person turns the wheel.
  void Start(int slot);
  // Returns once the wheel stands there; throws what a move has thrown.
  void Finish(int slot);
  void Home();
  // Waits for a move, whatever becomes of it; where the wheel stands is unknown from here on.
  void Forget();
  TimeSpan TakeSpan();  // of the last move, once

 private:
  void MoveNow(int slot);
  FilterWheel& wheel_;
  const Stopwatch& stopwatch_;
  std::future<void> move_;
  int moving_to_ = 0, stands_at_ = 0;  // 0: unknown
  TimeSpan span_;
};

}  // namespace dermap
