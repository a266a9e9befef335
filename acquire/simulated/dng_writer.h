// SPDX-License-Identifier: Apache-2.0
// Uncompressed colour-filter-array DNG, 12 bits a photosite, packed: two photosites in three bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/core/image.h"

namespace dermap {

inline constexpr int kDngWhiteLevel = 4095;

struct DngMetadata {
  double exposure_ms = 10.0;
  int iso = 100;
  int black_level = 126;
  std::array<double, 3> as_shot_neutral{1.0, 1.0, 1.0};
  std::string date_time = "2024:01:01 00:00:00";  // EXIF form
  std::string serial;                             // of the camera
  std::string description;                        // ImageDescription
};

// `bayer`: RGGB from the top left, values up to 4095, even width.
std::vector<std::byte> EncodeDng(const Plane<std::uint16_t>& bayer, const DngMetadata& metadata);

}  // namespace dermap
