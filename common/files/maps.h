// SPDX-License-Identifier: Apache-2.0
// Parameter maps (and any other named planes) as OpenEXR, float32.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/files/stack.h"
#include "common/tissue/parameters.h"

namespace dermap {

// What a maps file knows beside its planes: the conditions it was fitted under, so that `render` needs
// nothing else.
struct MapsFile {
  ParameterMaps maps;
  std::vector<Band> bands;  // the bands of the fit; junction_absorbance, where one a band, is in this order
  std::optional<double> pixel_size_mm;
  Illumination illumination = Illumination::kWindow;
  Tape tape = Tape::kFree;
  Geometry geometry = Geometry::kHemispherical;
};

MapsFile ReadMaps(const std::filesystem::path& path);
void WriteMaps(const std::filesystem::path& path, const MapsFile& maps);

// Named planes of one shape, in the order given (flags.exr, sigma.exr).
using NamedPlanes = std::vector<std::pair<std::string, PlaneF>>;
NamedPlanes ReadPlanes(const std::filesystem::path& path);
void WritePlanes(const std::filesystem::path& path, const NamedPlanes& planes,
                 std::optional<double> pixel_size_mm);

}  // namespace dermap
