// SPDX-License-Identifier: Apache-2.0
// The level at which a frame's values are clipped, from the data.
#pragma once

#include "calibrate/raw_frame.h"

namespace dermap {

// The value at which photosites stop answering, where a pile of them shows it: at most `stated`.
double SaturationLevel(const BayerFrame& frame, double stated);

}  // namespace dermap
