// SPDX-License-Identifier: Apache-2.0
// What only a person at the station can do, and how one is asked for it: on a terminal, or on the daemon's
// page.
#pragma once

#include <functional>
#include <string>

#include "common/files/session.h"

namespace dermap {

struct OperatorRequest {
  enum class Kind {
    kPlace,      // put the role's target in place
    kTurnWheel,  // turn a wheel without motor to a slot
    kFault,      // see to a device, then go on
  };
  Kind kind = Kind::kPlace;
  FrameRole role = FrameRole::kBlack;  // kPlace
  int slot = 0;                        // kTurnWheel
  std::string sentence;                // what to do, complete
};

// Returns once it is done; false where the session shall end instead.
using AskOperator = std::function<bool(const OperatorRequest&)>;

// "[place skin] Put the taped skin in place, ...": begins with what it is about, for programs that read
// along.
std::string RequestLine(const OperatorRequest& request);

// What to put in place for a role.
OperatorRequest PlaceRequest(FrameRole role);

}  // namespace dermap
