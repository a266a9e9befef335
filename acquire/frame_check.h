// SPDX-License-Identifier: Apache-2.0
// Whether a camera's file decodes, and how it is exposed: asked while the subject is still in place.
#pragma once

#include <string>

#include "acquire/devices/camera.h"

namespace dermap {

struct FrameCheck {
  bool decodes = false;
  std::string problem;  // why it does not
  int width_px = 0;
  int height_px = 0;
  double saturated_share = 0.0;  // photosites within 2 DN of the white level
  double level = 0.0;            // 99th percentile of the photosites, as a share of the range above black
};

FrameCheck CheckFrame(const RawFrame& frame);

}  // namespace dermap
