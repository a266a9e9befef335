// SPDX-License-Identifier: Apache-2.0
// Whether a camera's file decodes, how it was taken and how it is exposed: asked while the subject is still
// in place.
#pragma once

#include <array>
#include <string>

#include "acquire/devices/camera.h"

namespace dermap {

// Mean level of the gray card's photosites, red, green, blue, as shares of the range above black.
using CardLevel = std::array<double, 3>;

struct FrameSize {  // of the active area
  int width_px = 0;
  int height_px = 0;
  bool operator==(const FrameSize&) const = default;
};

struct FrameCheck {
  bool decodes = false;
  std::string problem;  // why it does not
  FrameSize size;
  double saturated_share = 0.0;     // photosites within 2 DN of the white level
  double level = 0.0;               // 99th percentile of the photosites, as a share of the range above black
  CardLevel card{};                 // 0 where no region was given
  double iso = 0.0;                 // as the file tells; 0 where it does not
  double exposure_ms = 0.0;         // as the file tells; 0 where it does not
  std::array<int, 64> histogram{};  // photosites by level, from black to white
};

// `card_region`: x, y, width, height as shares of the frame; all 0: no gray card.
FrameCheck CheckFrame(const RawFrame& frame, const std::array<double, 4>& card_region = {});

}  // namespace dermap
