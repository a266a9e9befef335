// SPDX-License-Identifier: Apache-2.0
// One move at a time, in a thread of its own.
#include "acquire/wheel_mover.h"

#include <utility>

namespace dermap {

WheelMover::~WheelMover() {
  if (move_.valid()) move_.wait();
}

void WheelMover::MoveNow(int slot) {
  span_.start_s = stopwatch_.Now();
  wheel_.MoveTo(slot);
  span_.end_s = stopwatch_.Now();
}

void WheelMover::Start(int slot) {
  if (move_.valid() || slot == stands_at_ || !wheel_.MovesByItself()) return;
  moving_to_ = slot;
  stands_at_ = 0;
  move_ = std::async(std::launch::async, [this, slot] { MoveNow(slot); });
}

void WheelMover::Finish(int slot) {
  if (move_.valid()) {
    std::exchange(move_, {}).get();
    stands_at_ = moving_to_;
  }
  if (stands_at_ == slot) return;
  stands_at_ = 0;
  MoveNow(slot);
  stands_at_ = slot;
}

void WheelMover::Home() {
  if (move_.valid()) std::exchange(move_, {}).get();
  wheel_.Home();
  stands_at_ = 0;
}

void WheelMover::Forget() {
  if (move_.valid()) move_.wait();
  move_ = {};
  stands_at_ = 0;
}

TimeSpan WheelMover::TakeSpan() {
  return std::exchange(span_, {});
}

}  // namespace dermap
