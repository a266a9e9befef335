// SPDX-License-Identifier: Apache-2.0
// Frames that are not what the session says: dark, swapped, saturated, through another filter, with a gray
// card that moved. Each throws CaptureFailure with the frame's picture.
#pragma once

#include <span>
#include <vector>

#include "calibrate/frames.h"
#include "calibrate/gray_card.h"

namespace dermap {

// Light has reached the card: the flash fired and no cap is on the lens.
void CheckLit(const SignalFrame& frame, const PixelRegion& card, double full_scale);

// Evenly bright in the middle, as a Spectralon panel is; else some black tape is in view.
bool EvenlyBright(const PlaneF& signal, const PixelRegion& card);

// A panel without tape in view, and not saturated throughout.
void CheckSpectralon(const SignalFrame& frame, const PixelRegion& card);

// The skin frame's card against the Spectralon frame's: the same card at the same place through the same
// filter, and a flash that fired. `drift`: of the flash, ISO taken out. Returns notes.
std::vector<std::string> CheckCard(const SignalFrame& skin, const SignalFrame& spectralon,
                                   const GrayCardRatio& ratio, double drift, const PixelRegion& card);

}  // namespace dermap
