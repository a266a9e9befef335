// SPDX-License-Identifier: Apache-2.0
// Names of faults, as the journal and the daemon have them.
#include "acquire/devices/device_fault.h"

namespace dermap {

std::string_view FaultName(FaultKind kind) {
  switch (kind) {
    case FaultKind::kBusy:
      return "busy";
    case FaultKind::kNoAnswer:
      return "no answer";
    case FaultKind::kGone:
      return "gone";
    case FaultKind::kInUse:
      return "in use";
    case FaultKind::kNoPermission:
      return "no permission";
    case FaultKind::kFull:
      return "card full";
    case FaultKind::kStuck:
      return "stuck";
    case FaultKind::kSettings:
      return "settings";
  }
  return "unknown";
}

}  // namespace dermap
