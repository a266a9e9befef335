// SPDX-License-Identifier: Apache-2.0
// The smooth warp by which one picture lies on another, and how sure it is.
#pragma once

#include <array>
#include <cstdint>

#include "calibrate/patch_map.h"
#include "common/core/image.h"

namespace dermap {

// A picture and its slopes.
struct SlopedPicture {
  PlaneF value, dx, dy;
  explicit SlopedPicture(PlaneF picture);
};

using WarpPrior = std::array<double, Warp::kModes>;  // one standard deviation of the modes, pixels

struct WarpProblem {
  const SlopedPicture& reference;
  const PlaneF& band;
  const Plane<std::uint8_t>& mask;
  double smooth_px;  // of both, for the number of samples that are independent
  int modes;         // used, of each direction
  WarpPrior prior_px;
};

struct WarpFit {
  double correlation = 0.0;
  double uncertainty_px = 0.0;  // one standard deviation of the shift
  double step_px = 0.0;         // the last one's
};

inline constexpr double kSettledWarp_px = 0.01;  // what moves less stands still

// From where `warp` is.
WarpFit SearchWarp(const WarpProblem& problem, Warp& warp);

}  // namespace dermap
