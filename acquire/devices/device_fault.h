// SPDX-License-Identifier: Apache-2.0
// What is wrong with a device, by what helps: the drivers retry by this, and what lasts is told to the
// operator.
#pragma once

#include <string>
#include <string_view>

#include "common/core/error.h"

namespace dermap {

enum class FaultKind {
  kBusy,          // it asks to be asked again
  kNoAnswer,      // it hangs, or answers what cannot be: a new connection may help
  kGone,          // unplugged, asleep, switched off: waiting for it helps
  kInUse,         // another program holds it
  kNoPermission,  // the system does not let us
  kFull,          // the card takes no more frames
  kStuck,         // it moves no more
  kSettings,      // it cannot be set as the plan asks
};
std::string_view FaultName(FaultKind kind);  // "busy", "no answer", ...

class DeviceFault : public DeviceError {
 public:
  DeviceFault(FaultKind kind, const std::string& message) : DeviceError(message), kind_(kind) {}
  FaultKind kind() const noexcept { return kind_; }

 private:
  FaultKind kind_;
};

}  // namespace dermap
