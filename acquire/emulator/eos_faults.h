// SPDX-License-Identifier: Apache-2.0
// What an emulated camera does wrong, and when: each fault waits for one press of the shutter, counted
// from 1.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquire/emulator/usb_device.h"

namespace dermap::emulator {

enum class EosFault {
  kBusy,        // answers DeviceBusy, `times` times
  kStall,       // the endpoint stalls once, until the halt is cleared
  kHang,        // answers nothing for `seconds`
  kUnplug,      // off the bus as the shutter is pressed, back after `seconds`
  kUnplugRead,  // off the bus in the middle of the transfer of that shot
  kSleep,       // as unplugged, before it has exposed
  kFull,        // the card is full, for `seconds` (0: for good)
  kRam,         // the capture target flips to RAM
  kLate,        // the file comes `seconds` later than it should
  kMissing,     // no file comes
  kTruncated,   // the file is cut in half
  kRepeated,    // the file is that of the shot before
  kSettings,    // ISO jumps to 800 just before the shot
  kTaken,       // off the bus for a moment; another program is quicker, and holds it for `seconds`
  kKilled,      // the emulator itself dies, and with it whoever has its devices open
};
std::optional<EosFault> EosFaultFromName(const std::string& name);  // "busy", "stall", "unplug-read", ...

struct PlannedFault {
  EosFault fault = EosFault::kBusy;
  int press = 1;
  double seconds = 0.5;
  int times = 1;
};

class EosFaults {
 public:
  void Plan(const PlannedFault& fault) { planned_.push_back(fault); }
  // Counts a press, and returns the fault that strikes at it.
  std::optional<PlannedFault> AtPress();
  int presses() const { return presses_; }

  Clock::time_point silent_until{};
  Clock::time_point full_until{};
  bool full_for_good = false;
  bool stalled = false;
  bool unplug_at_read = false;
  double unplug_seconds = 0.5;

 private:
  std::vector<PlannedFault> planned_;
  int presses_ = 0;
};

}  // namespace dermap::emulator
