// SPDX-License-Identifier: Apache-2.0
// The shorter way round, at constant speed.
#include "acquire/emulator/wheel_motion.h"

#include <algorithm>
#include <cstdlib>

namespace dermap::emulator {

WheelMotion::WheelMotion(int slot_count, double seconds_per_slot)
    : slot_count_(slot_count), seconds_per_slot_(seconds_per_slot) {}

int WheelMotion::Around(int slot) const {
  return (slot - 1 + slot_count_) % slot_count_ + 1;
}

void WheelMotion::Home() {
  slip = 0;
  Turn(1);
}

void WheelMotion::MoveTo(int slot) {
  ++moves_;
  if (on_move) on_move(moves_);
  Turn(slot);
}

void WheelMotion::Turn(int slot) {
  const int distance = std::abs(slot - target_);
  const int way = std::min(distance, slot_count_ - distance);
  from_ = target_;
  target_ = slot;
  jammed_ = stuck;
  arrives_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(way * seconds_per_slot_));
}

int WheelMotion::Reported() const {
  return jammed_ || Clock::now() < arrives_ ? 0 : target_;
}

int WheelMotion::InTheLight() const {
  if (jammed_) return Around(from_ + slip);
  return Clock::now() < arrives_ ? 0 : Around(target_ + slip);
}

}  // namespace dermap::emulator
