// SPDX-License-Identifier: Apache-2.0
// How a patch was lit and seen, as far as the forward model must know.
#pragma once

#include <vector>

namespace dermap {

enum class Illumination { kWindow, kUniform };        // ends at the image's border (tape) | goes on
enum class Tape { kFree, kBlack };                    // the skin's surface under the tape: as in air | absorbs
enum class Geometry { kHemispherical, kFactor0_30 };  // all exit angles | reflectance factor seen at 30 degrees

struct ImagingConditions {
  double pixel_size_mm = 0.0;  // > 0
  Illumination illumination = Illumination::kWindow;
  Tape tape = Tape::kFree;
  Geometry geometry = Geometry::kHemispherical;
};

// A spectral band: centre and full width at half maximum of its (Gaussian) filter; width 0 is monochromatic.
struct Band {
  double wavelength_nm = 0.0;
  double fwhm_nm = 0.0;
};

}  // namespace dermap
