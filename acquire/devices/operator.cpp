// SPDX-License-Identifier: Apache-2.0
// The sentences that an operator reads.
#include "acquire/devices/operator.h"

namespace dermap {

std::string RequestLine(const OperatorRequest& request) {
  std::string about = "fault";
  if (request.kind == OperatorRequest::Kind::kPlace) about = "place " + std::string(RoleName(request.role));
  if (request.kind == OperatorRequest::Kind::kTurnWheel) about = "turn " + std::to_string(request.slot);
  return "[" + about + "] " + request.sentence;
}

OperatorRequest PlaceRequest(FrameRole role) {
  OperatorRequest request;
  request.role = role;
  switch (role) {
    case FrameRole::kBlack:
      request.sentence =
          "Close the door or darken the room: the black frames are taken through the opaque slot.";
      break;
    case FrameRole::kSpectralon:
      request.sentence = "Put the Spectralon panel in the place of the skin, gray card in view.";
      break;
    case FrameRole::kSkin:
      request.sentence =
          "Put the taped skin in place, window in the middle, gray card in view, and hold still.";
      break;
  }
  return request;
}

}  // namespace dermap
