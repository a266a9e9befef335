// SPDX-License-Identifier: Apache-2.0
// The gray card that stands in every frame and tells how bright the flash was [D08 6.1].
#pragma once

#include <array>

#include "calibrate/frames.h"

namespace dermap {

struct PixelRegion {  // photosites; even corners and sizes
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// The rig's gray_card_region (shares of the frame) in photosites. Throws InputError where it leaves the frame
// or is too small to be read.
PixelRegion GrayCardRegion(const RigConfig& rig, int frame_width, int frame_height);

// Mean signal of the strongest colour in the region over usable photosites, DN.
double GrayCardSignal(const SignalFrame& frame, const PixelRegion& card);

struct GrayCardRatio {
  double ratio = 0.0;  // of the sums over photosites that are usable in both
  double unevenness =
      0.0;  // largest deviation of a sixteenth of the card from the whole: a shadow, or a moved card
  double colour_difference = 0.0;  // largest deviation of a colour's ratio from the whole: another filter
  OfKinds mean_a{};
  OfKinds mean_b{};
  OfKinds count{};  // photosites
  // The ratio after constants are taken off every photosite's signal, by kind.
  double RatioWithout(const OfKinds& a, const OfKinds& b) const;
};
// How much brighter the card is in `a` than in `b`. The same card at the same place: reflectance, light
// falloff and vignetting divide out. ratio is NaN where nothing is usable.
GrayCardRatio CompareGrayCard(const SignalFrame& a, const SignalFrame& b, const PixelRegion& card);

}  // namespace dermap
