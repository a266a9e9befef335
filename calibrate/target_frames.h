// SPDX-License-Identifier: Apache-2.0
// Frames of targets that stand behind the window in the skin's place, bright and dark ones, read and summed:
// what the stray light of a rig's lens is measured from.
#pragma once

#include <vector>

#include "calibrate/gray_card.h"
#include "calibrate/tape.h"
#include "common/transport/conditions.h"

namespace dermap {

// Beside the band's Spectralon frame.
struct TargetFrame {
  std::string file;
  FrameMeans means;
  GrayCardRatio card;
  TapeSignals tape{};
  RegionSignals middle;
};

struct BandTargets {
  Band band;
  double white = 1.0;  // signal of the Spectralon, of a perfect white diffuser's mean over the polarizer
  std::vector<TargetFrame> frames;
};

// All frames of a band are summed around the window that its brightest one shows, since dark targets show
// none. Throws InputError (CaptureFailure where there is something to be seen): frames that are dark or
// saturated, no Spectralon, no window.
std::vector<BandTargets> ReadTargets(const Session& session, const FrameReader& read,
                                     const BlackFrames& blacks, const PixelRegion& card);

// Two sessions of one rig, a target each, as one.
Session JoinSessions(const Session& first, const Session& second);

}  // namespace dermap
