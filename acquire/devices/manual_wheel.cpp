// SPDX-License-Identifier: Apache-2.0
// Asking, and believing the answer: the frame's light is checked anyway.
#include "acquire/devices/manual_wheel.h"

#include <algorithm>
#include <cmath>

#include "acquire/devices/device_fault.h"

namespace dermap {

ManualWheel::ManualWheel(const RigConfig& rig, AskOperator ask) : slots_(rig.slots), ask_(std::move(ask)) {
  for (const WheelSlot& s : slots_) slot_count_ = std::max(slot_count_, s.slot);
}

void ManualWheel::MoveTo(int slot) {
  if (slot == stands_at_) return;
  const auto found =
      std::find_if(slots_.begin(), slots_.end(), [&](const WheelSlot& s) { return s.slot == slot; });
  const std::string filter = found == slots_.end() ? ""
                             : found->opaque
                                 ? ", the opaque one"
                                 : ", " + std::to_string(std::lround(found->wavelength_nm)) + " nm";
  OperatorRequest request;
  request.kind = OperatorRequest::Kind::kTurnWheel;
  request.slot = slot;
  request.sentence = "Turn the filter wheel to slot " + std::to_string(slot) + filter + ".";
  if (!ask_ || !ask_(request)) {
    throw DeviceFault(FaultKind::kStuck, "nobody turned the wheel to slot " + std::to_string(slot) +
                                             "; remedy: run the capture where somebody can answer it");
  }
  stands_at_ = slot;
}

}  // namespace dermap
