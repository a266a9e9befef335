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

struct BayerFrame {
  Plane<std::uint16_t> values;                // active area as read: black not subtracted, nothing rotated
  std::array<char, kLatticeCount> colours{};  // 'R', 'G' or 'B' of each lattice
  double black_level = 0.0;                   // as the file states it, mean over the colours
  double white_level = 0.0;                   // values from here on are saturated
  double exposure_ms = 0.0;                   // 0 where the file does not say
  int iso = 0;                                // 0 where the file does not say
};

// DNG, CR2 and whatever else LibRaw reads, as long as it holds a 2x2 Bayer pattern.
// Throws InputError that names the file: missing, foreign, truncated, no Bayer pattern, absurd size.
BayerFrame ReadBayerFrame(const std::filesystem::path& path);

}  // namespace dermap
