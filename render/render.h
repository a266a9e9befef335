// SPDX-License-Identifier: Apache-2.0
// Renders maps again: under other light, with other chromophores, at other wavelengths.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/files/maps.h"
#include "common/files/stack.h"
#include "common/spectra/colour.h"
#include "common/transport/forward_model.h"

namespace dermap {

struct RenderOptions {
  std::string light = "uniform";   // see MakeLight
  std::vector<std::string> edits;  // see ParseEdit; applied in this order
  std::vector<double>
      wavelengths_nm;              // monochromatic bands; empty: the bands of the maps, else [D08 7]'s eight
  std::string profiles = "exact";  // see MakeProfileSource
  ForwardOptions forward;
  TissueConfig tissue;
  std::optional<double> pixel_size_mm;  // instead of the maps' own
};

struct RenderResult {
  ReflectanceStack image;           // light that leaves the skin, per unit of a capture's irradiance
  Plane<Rgb8> colour;               // under daylight (CIE D65) with this pattern
  double exposure = 1.0;            // factor on the reflectance in `colour`
  std::vector<std::string> notes;   // sentences: what was assumed, edited, clamped
  std::vector<BandChoice> forward;  // what the engine `lowrank` took for each band; otherwise empty
  double seconds = 0.0;             // of the render itself, without the tables
};

// Throws InputError for maps or options that cannot be rendered.
RenderResult RenderMaps(const MapsFile& maps, const RenderOptions& options, const Chromophores& chromophores,
                        const std::filesystem::path& spectra_dir, const ProgressFunction& progress = {});

// The stack at `path` (.exr or .hdr) and the colour picture beside it with the extension .png. Throws
// StorageError.
void WriteRender(const std::filesystem::path& path, const RenderResult& result);

}  // namespace dermap
