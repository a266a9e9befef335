// SPDX-License-Identifier: Apache-2.0
// Canon's way through a frame: vertical strips side by side, each from top to bottom, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "calibrate/lossless_jpeg.h"

namespace dermap {

struct StripLayout {
  int strips = 1;
  int width = 0;       // of all but the last, photosites
  int last_width = 0;  // all in all the frame's width
  int height = 0;
};

// Whether the JPEG holds as many values as the strips, no more and no less.
bool Fills(const LosslessJpeg& jpeg, const StripLayout& layout);

// All of its values into the strips of `frame`, whose rows begin `pitch` values apart; Fills() is asked
// first. False where the data are damaged: then the rest is as it was.
bool DecodeStrips(LosslessJpeg& jpeg, const StripLayout& layout, std::size_t pitch, std::uint16_t* frame);

}  // namespace dermap
