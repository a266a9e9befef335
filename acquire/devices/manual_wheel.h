// SPDX-License-Identifier: Apache-2.0
// The driver "manual": a wheel without motor, or a filter holder, that the operator turns [D08 7.2].
#pragma once

#include "acquire/devices/filter_wheel.h"
#include "acquire/devices/operator.h"
#include "common/files/rig.h"

namespace dermap {

class ManualWheel : public FilterWheel {
 public:
  ManualWheel(const RigConfig& rig, AskOperator ask);
  std::string Name() const override { return "wheel turned by hand"; }
  int SlotCount() const override { return slot_count_; }
  bool MovesByItself() const override { return false; }
  void Home() override { stands_at_ = 0; }  // asks again, even for the slot that it was asked for last
  void MoveTo(int slot) override;

 private:
  std::vector<WheelSlot> slots_;
  AskOperator ask_;
  int slot_count_ = 0;
  int stands_at_ = 0;
};

}  // namespace dermap
