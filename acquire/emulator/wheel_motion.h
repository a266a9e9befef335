// SPDX-License-Identifier: Apache-2.0
// The mechanics of an emulated filter wheel: seconds from slot to slot, and what can go wrong with them.
#pragma once

#include <chrono>
#include <functional>

#include "acquire/emulator/usb_device.h"

namespace dermap::emulator {

class WheelMotion {
 public:
  // `seconds_per_slot`: 0 turns at once.
  WheelMotion(int slot_count, double seconds_per_slot);

  int slot_count() const { return slot_count_; }
  void MoveTo(int slot);
  void Home();  // finds its slots anew: slips no more
  // What the wheel says: the slot, or 0 while it turns.
  int Reported() const;
  // Which slot the light passes; 0 while the wheel turns.
  int InTheLight() const;

  std::function<void(int move)> on_move;  // before each move, counted from 1
  bool stuck = false;                     // turns no more: says that it moves, for ever
  int slip = 0;                           // stands this many slots beyond what it says

 private:
  int Around(int slot) const;
  void Turn(int slot);
  int moves_ = 0;
  int slot_count_;
  double seconds_per_slot_;
  int from_ = 1, target_ = 1;
  bool jammed_ = false;  // was stuck when told to move
  Clock::time_point arrives_{};
};

}  // namespace dermap::emulator
