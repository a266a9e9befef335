// SPDX-License-Identifier: Apache-2.0
// How a patch was lit and seen, as far as the forward model must know.
#pragma once

#include <vector>

namespace dermap {

// Whether the light ends at the image's border (beyond it lies tape) or goes on.
enum class Illumination { kWindow, kUniform };
// What the skin's surface does under the tape: it reflects as in air, or what reaches it from below is
// absorbed.
enum class Tape { kFree, kBlack };
// All exit angles, or a reflectance factor seen at 30 degrees.
enum class Geometry { kHemispherical, kFactor0_30 };

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
