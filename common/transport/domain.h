// SPDX-License-Identifier: Apache-2.0
// The piece of skin that takes part in a render: the patch and a margin around it.
#pragma once

#include "common/core/image.h"

namespace dermap {

// A rectangle of pixels.
struct Region {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Region&) const = default;
};

struct Domain {
  int width = 0, height = 0;
  Region patch;
  int levels = 0;  // how often width and height can be halved

  bool operator==(const Domain&) const = default;
  Region Whole() const { return {0, 0, width, height}; }
};

// At least `margin_px` on each side, and a little more where width and height must be multiples of a power of
// two.
Domain MakeDomain(int patch_width, int patch_height, double margin_px);

// The patch's plane with its edge repeated outwards, or with zeros around it.
void ReplicateOutwards(const PlaneF& patch, const Domain& domain, PlaneF& whole);
void SurroundWithZeros(const PlaneF& patch, const Domain& domain, PlaneF& whole);

// Gives `plane` this shape if it has another; its values are then zero, otherwise what they were.
void EnsureShape(PlaneF& plane, int width, int height);

}  // namespace dermap
