// SPDX-License-Identifier: Apache-2.0
// Pictures for people: planes as false colours or gray, PNG files and bytes. Data for programs goes to EXR
// instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/image.h"
#include "common/spectra/colour.h"

namespace dermap {

// Perceptually even maps. Gray is the sRGB curve of the value's share of the scale (a photograph); the others
// go evenly through the scale. Diverging: blue below, near white in the middle, red above.
enum class ColourMap { kGray, kViridis, kMagma, kInferno, kDiverging };

struct Scale {  // the values at the two ends of a colour map
  double low = 0.0;
  double high = 1.0;
};

// From percentile `tail_percent` to 100 - tail_percent of the finite values, never of zero width; [0, 1]
// without values.
Scale RobustScale(std::span<const float> values, double tail_percent = 1.0);
// The same over several planes together.
Scale RobustScale(std::span<const PlaneF> planes, double tail_percent = 1.0);
// Symmetric about 0: for differences.
Scale SymmetricScale(std::span<const float> values, double tail_percent = 1.0);

// Colour at `fraction` (0 low ... 1 high, clamped) of a map.
Rgb8 ColourAt(ColourMap map, double fraction);
// Values beyond the scale take its ends' colours; NaN and infinity take kMissingColour.
Plane<Rgb8> Colourise(const PlaneF& plane, ColourMap map, const Scale& scale);

// Area-weighted mean over each new pixel; where the new size is larger in either direction, linear
// interpolation. Missing (not finite) values take no part; a new pixel without any value is NaN.
PlaneF ResizeByArea(const PlaneF& plane, int width, int height);

// About `count` ticks within [low, high], at least two, at 1, 2 or 5 times a power of ten.
std::vector<double> NiceTicks(double low, double high, int count);
// As few decimals as tell neighbours `step` apart from one another: "0.05", "1200", "2e-5".
std::string FormatTick(double value, double step);
// A value for people: `digits` significant ones, no useless zeros.
std::string FormatValue(double value, int digits = 3);

// Photographs of skin in which reflectance 1 is white are dark on a screen: the factor, 1 to 2, that brings
// the bright parts of the brightest band to 0.8.
double DisplayExposure(std::span<const PlaneF> reflectance);

std::vector<std::byte> EncodePng(const Plane<Rgb8>& picture);
std::vector<std::byte> EncodePng(const Plane<std::uint8_t>& picture);
// Atomic; throws StorageError.
void WritePng(const std::filesystem::path& path, const Plane<Rgb8>& picture);
// "data:image/png;base64,...", for pages that must open without their folder.
std::string DataUri(std::span<const std::byte> bytes, std::string_view mime_type = "image/png");

}  // namespace dermap
