// SPDX-License-Identifier: Apache-2.0
// Frames of one session as signals above black, in DN, and the photosites that must not be used.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calibrate/black_frames.h"

namespace dermap {

// One exposed frame above black.
struct SignalFrame {
  FrameRecord record;
  const BlackReference* black = nullptr;
  int period = 2;  // of the filter pattern
  PlaneF signal;   // DN above black
  MaskPlane mask;  // saturated (with the nearest photosites of its colour, where noise is clipped) and hot
  double saturated_share = 0.0;
  std::vector<std::string> notes;
};

// Mean signal of each kind of photosites over the whole frame, hot ones left out.
OfKinds KindMeans(const SignalFrame& frame);

// Reads, checks against the sensor and subtracts black. Throws InputError naming the frame.
SignalFrame ReadSignal(const FrameRecord& record, const FrameReader& read, const BlackFrames& blacks);

// Adds kPhotositeDead to `mask` wherever a frame of an even target answers unlike the photosites of its kind
// around.
void MarkDead(const PlaneF& spectralon, int period, MaskPlane& mask);

}  // namespace dermap
