// SPDX-License-Identifier: Apache-2.0
// What the black tape around the window shows, and the middle of the window: sums over photosites.
#pragma once

#include <array>

#include "calibrate/mosaic.h"
#include "calibrate/window.h"

namespace dermap {

struct FrameMeans {  // mean signal of each kind of photosites over the whole frame, DN
  OfKinds skin{};
  OfKinds spectralon{};
};

struct RegionSignals {
  double skin = 0.0, spectralon = 0.0;            // sums of the signals, DN
  double skin_mean = 0.0, spectralon_mean = 0.0;  // were each photosite at its kind's mean over the frame
  double count = 0.0;                             // of photosites
  void Add(const RegionSignals& o);
};

inline constexpr int kTapeStretches = 16;  // four along each side of the window
using TapeSignals = std::array<RegionSignals, kTapeStretches>;

// The tape between two distances from the window's edge, in shares of its side.
TapeSignals SumTape(const Mosaic& mosaic, const Window& window, const FrameMeans& means, double from,
                    double to);

// Clear of the tape and of its shadow.
RegionSignals SumMiddle(const Mosaic& mosaic, const Window& window, const FrameMeans& means);

}  // namespace dermap
