// SPDX-License-Identifier: Apache-2.0
// What bands share inside the window: fine structure in log reflectance.
#pragma once

#include <cstdint>
#include <span>

#include "calibrate/patch_map.h"
#include "common/core/image.h"

namespace dermap {

inline constexpr double kStructureSmooth_px = 1.0;  // of every structure, against noise

// Of one band, scaled to a standard deviation of 1 within the mask.
struct Structure {
  PlaneF picture;
  Plane<std::uint8_t> mask;  // 255: inside the border and present
  double weight = 0.0;       // in the mean of the others: the share of its variance that is not noise
};
Structure StructureOf(const PlaneF& reflectance, const PlaneF& noise, int border_px);

PlaneF Smoothed(const PlaneF& picture, double sigma_px);
PlaneF Moved(const PlaneF& picture, const Warp& warp);
Point UnitOf(int x, int y, const PlaneF& picture);

// Mean of the structures but one, moved into place, weighted by how much of each is not noise. Empty where
// there is none.
PlaneF MeanOfOthers(std::span<const Structure> structures, std::span<const PlaneF> moved, std::size_t self);

}  // namespace dermap
