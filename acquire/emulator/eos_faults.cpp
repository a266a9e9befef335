// SPDX-License-Identifier: Apache-2.0
// Names and counting of faults.
#include "acquire/emulator/eos_faults.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace dermap::emulator {

std::optional<EosFault> EosFaultFromName(const std::string& name) {
  using Named = std::pair<std::string_view, EosFault>;
  static constexpr std::array kNames{Named{"busy", EosFault::kBusy},
                                     Named{"stall", EosFault::kStall},
                                     Named{"hang", EosFault::kHang},
                                     Named{"unplug", EosFault::kUnplug},
                                     Named{"unplug-read", EosFault::kUnplugRead},
                                     Named{"sleep", EosFault::kSleep},
                                     Named{"full", EosFault::kFull},
                                     Named{"ram", EosFault::kRam},
                                     Named{"late", EosFault::kLate},
                                     Named{"missing", EosFault::kMissing},
                                     Named{"truncated", EosFault::kTruncated},
                                     Named{"repeated", EosFault::kRepeated},
                                     Named{"settings", EosFault::kSettings},
                                     Named{"second-client", EosFault::kTaken},
                                     Named{"emulator-killed", EosFault::kKilled}};
  const auto found =
      std::find_if(kNames.begin(), kNames.end(), [&](const Named& n) { return n.first == name; });
  return found == kNames.end() ? std::nullopt : std::optional(found->second);
}

std::optional<PlannedFault> EosFaults::AtPress() {
  ++presses_;
  for (auto it = planned_.begin(); it != planned_.end(); ++it) {
    if (it->press != presses_) continue;
    const PlannedFault fault = *it;
    if (--it->times > 0) {
      ++it->press;  // strikes the next press as well
    } else {
      planned_.erase(it);
    }
    return fault;
  }
  return std::nullopt;
}

}  // namespace dermap::emulator
