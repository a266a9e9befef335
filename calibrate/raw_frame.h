// SPDX-License-Identifier: Apache-2.0
// A camera's raw file as exact sensor values, one number a photosite, in DN (the file's own steps).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "common/core/image.h"

namespace dermap {

// The four photosites of a 2x2 cell, each with neighbours of its own kind two photosites away.
inline constexpr int kLatticeCount = 4;
constexpr int LatticeOf(int x, int y) {
  return 2 * (y & 1) + (x & 1);
}

// Which photosite of a filter pattern that repeats after `period`: its kind. Of period 2 kinds are lattices.
inline constexpr int kMostKinds = 36;
using OfKinds = std::array<double, kMostKinds>;
constexpr int KindOf(int x, int y, int period) {
  return period * (y % period) + x % period;
}

struct BayerFrame {
  Plane<std::uint16_t> values;  // active area as read: black not subtracted, nothing rotated
  std::array<char, kLatticeCount>
      colours{};  // 'R', 'G', 'B', ... of each lattice; 'W' without filters, 'X' below
  // Photosites after which the filters repeat: 2, or 6 (X-Trans), where a lattice holds several colours.
  int period = 2;
  double black_level = 0.0;  // as the file states it, mean over the colours
  double white_level = 0.0;  // values from here on are saturated
  double exposure_ms = 0.0;  // 0 where the file does not say
  int iso = 0;               // 0 where the file does not say
};

// DNG, CR2, CR3, NEF, ARW, RAF and whatever else LibRaw reads, as long as it holds one value a photosite: any
// 2x2 pattern, X-Trans, or none (monochrome). Orientation tags are not heeded: the frame is as the sensor
// lies. Throws InputError that names the file: missing, foreign, truncated, demosaiced already, absurd size.
BayerFrame ReadBayerFrame(const std::filesystem::path& path);

struct RawExposure {
  double exposure_ms = 0.0;  // 0 where the file does not say
  int iso = 0;
};
// The file's header alone.
RawExposure ReadRawExposure(const std::filesystem::path& path);

}  // namespace dermap
