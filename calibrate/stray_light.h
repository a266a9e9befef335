// SPDX-License-Identifier: Apache-2.0
// Light that the lens spreads evenly over the frame, told by the black tape around the window, whose
// reflectance the rig states, and by what the rig states of the lens.
#pragma once

#include <optional>

#include "calibrate/gray_card.h"
#include "calibrate/tape.h"
#include "common/files/rig_optics.h"

namespace dermap {

struct StrayLight {
  Known share;              // of a frame's mean signal that lies on every photosite
  double tape = 0.0;        // reflectance that the tape seems to have without the correction
  double card_ratio = 0.0;  // skin over Spectralon, stray light taken off
};

// Every photosite shows its own light and `share` of its colour's mean over the frame. The tape then seems
// brighter than it is:
//   scale (skin - share mean_skin) = tape (spectralon - share mean_spectralon),
// scale = certificate / card ratio, itself freed of stray light. A frame that is dark but for a small window
// tells little: the share is then drawn towards what was `expected` beforehand, and its sigma says how much
// is left open. Where no tape is seen, or nothing known of it, that is all.
StrayLight EstimateStrayLight(const Mosaic& mosaic, const Window& window, const FrameMeans& means,
                              const GrayCardRatio& card, double certificate,
                              const std::optional<Known>& tape_reflectance, const Known& expected);

// Of a lens of which nothing else is known.
inline constexpr Known kUsualStrayLight{0.0, 0.02};

// The ratio of the gray card's signals, stray light taken off.
double CardRatioWithout(double share, const FrameMeans& means, const GrayCardRatio& card);

// Takes it off both frames; its shot noise stays.
void RemoveStrayLight(double share, const FrameMeans& means, Mosaic& mosaic);

}  // namespace dermap
