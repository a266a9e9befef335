// SPDX-License-Identifier: Apache-2.0
// A plane as a picture that explains itself: title, colour bar with its unit and range, length bar. For PNG
// previews.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/files/picture.h"

namespace dermap {

struct MapPicture {
  std::string title;  // ASCII: the built-in fonts have no more
  std::string unit;   // beneath the title: what the numbers on the bar mean
  ColourMap map = ColourMap::kViridis;
  std::optional<Scale> scale;           // default: percentiles 1 to 99 of the values
  std::optional<double> pixel_size_mm;  // draws a length bar
};

// Small planes are enlarged pixel by pixel, large ones reduced to at most 512 px. Values beyond the scale
// show as arrow heads at the ends of the bar, pixels without a value in kMissingColour with a note.
Plane<Rgb8> DrawMap(const PlaneF& plane, const MapPicture& options);
void WriteMapPng(const std::filesystem::path& path, const PlaneF& plane, const MapPicture& options);

}  // namespace dermap
