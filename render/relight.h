// SPDX-License-Identifier: Apache-2.0
// Light patterns: relative irradiance on the patch, 1 where the light is as in a capture.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/transport/conditions.h"

namespace dermap {

struct LightPattern {
  std::vector<PlaneF> planes;      // none (1 everywhere), one for all bands, or one a band
  std::string description;         // a sentence for people
  std::vector<std::string> notes;  // what was assumed
};

// The patch that is lit.
struct LitPatch {
  int width = 0, height = 0;
  double pixel_size_mm = 0.0;
};

// `name` is one of
//   uniform          1 everywhere
//   stripes:1.0mm    upright stripes of this period, half of it lit, half dark (the unit may be left out)
//   spot:2.0mm       a disc of this diameter in the middle of a dark patch
//   FILE.exr         a picture of the light (ReadLight)
// Pixels that an edge crosses are lit by the share of their area. Throws InputError that lists these forms.
LightPattern MakeLight(const std::string& name, const LitPatch& patch, std::span<const Band> bands);

// One plane for all bands: the channel Y, L, light, or whatever is the file's only channel. Or one a band:
// channels light.450,000000nm or T.450,000000nm, joined linearly between wavelengths and constant beyond
// them. Values are finite and not negative. The picture is area-averaged or interpolated to the patch, whose
// shape it must have within 1 %.
LightPattern ReadLight(const std::string& path, const LitPatch& patch, std::span<const Band> bands);

}  // namespace dermap
