// SPDX-License-Identifier: Apache-2.0
// Sums over the square of pixels around each.
#pragma once

#include "common/core/image.h"

namespace dermap {

// Of 2 reach + 1 pixels a side, fewer at a border; whatever the reach, in the same time.
PlaneF SumsAround(const PlaneF& plane, int reach);

}  // namespace dermap
