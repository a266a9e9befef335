// SPDX-License-Identifier: Apache-2.0
// A small picture of a raw frame for the operator, and what one glance at it tells.
#pragma once

#include <string>

#include "acquire/devices/camera.h"

namespace dermap {

struct FrameView {
  std::string png;         // gray, at most 240 pixels wide, brightened by a square root
  double sharpness = 0.0;  // mean square of the Laplacian over that of the level: compare within one filter
  bool window_found = false;  // a bright quadrangle on dark ground
};

// Of a frame that CheckFrame (acquire/frame_check.h) decodes.
FrameView MakeFrameView(const RawFrame& frame);

}  // namespace dermap
