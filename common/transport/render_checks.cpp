// SPDX-License-Identifier: Apache-2.0
// Checks at the forward model's door, so that its loops need none.
#include "common/transport/render_checks.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "common/core/error.h"
#include "common/optics/path_kernels.h"
#include "common/optics/profile_table.h"

namespace dermap {
namespace {

constexpr double kLongestMargin_mm = 50.0;
constexpr double kLargestTolerance = 0.1;
constexpr int kMostTerms = 1000;

std::string Shape(const PlaneF& plane) {
  return std::to_string(plane.width()) + " x " + std::to_string(plane.height());
}

void CheckFinite(const PlaneF& plane, std::string_view name) {
  const auto bad =
      std::find_if(plane.values().begin(), plane.values().end(), [](float v) { return !std::isfinite(v); });
  if (bad == plane.values().end()) return;
  const auto at = bad - plane.values().begin();
  throw InputError("map '" + std::string(name) + "' holds a value that is not a finite number at x = " +
                   std::to_string(at % plane.width()) + ", y = " + std::to_string(at / plane.width()) +
                   "; every pixel needs one: fill in what is missing before rendering");
}

void CheckShape(const PlaneF& plane, std::string_view name, const ParameterMaps& maps) {
  if (plane.SameShape(maps[Parameter::kC_m])) return;
  throw InputError("map '" + std::string(name) + "' is " + Shape(plane) + " pixels but C_m is " +
                   Shape(maps[Parameter::kC_m]) + "; all planes of a render must have one shape");
}

// One plane for all bands, or one a band.
void CheckCount(std::size_t found, int band_count, std::string_view name) {
  if (found == 1 || found == static_cast<std::size_t>(band_count)) return;
  throw InputError("there are " + std::to_string(found) + " planes of " + std::string(name) + " for " +
                   std::to_string(band_count) + " bands; give one for all bands or one a band");
}

}  // namespace

void CheckModelInputs(std::span<const Band> bands, const ImagingConditions& conditions,
                      const ForwardOptions& options) {
  if (bands.empty()) throw InputError("there is no band to render; name at least one wavelength");
  for (const Band& band : bands) {
    if (!std::isfinite(band.wavelength_nm) || !(band.fwhm_nm >= 0.0) || !std::isfinite(band.fwhm_nm)) {
      throw InputError("the band at " + std::to_string(band.wavelength_nm) + " nm has a width of " +
                       std::to_string(band.fwhm_nm) + " nm; both must be finite, and the width 0 or more");
    }
  }
  if (!(conditions.pixel_size_mm > 0.0) || !std::isfinite(conditions.pixel_size_mm)) {
    throw InputError(
        "the pixel size is " + std::to_string(conditions.pixel_size_mm) +
        " mm; lateral transport needs one above 0 (--pixel-size-mm, or the attribute dermap:pixelSizeMm)");
  }
  if (!(options.tolerance > 0.0 && options.tolerance <= kLargestTolerance)) {
    throw InputError("the tolerance of a render is " + std::to_string(options.tolerance) +
                     "; it must be above 0 and at most 0.1 (relative, rms)");
  }
  const bool automatic = options.margin_mm == kAutomaticMargin;
  if (!automatic && (!(options.margin_mm >= 0.0) || options.margin_mm > kLongestMargin_mm)) {
    throw InputError("the margin is " + std::to_string(options.margin_mm) + " mm; it must be 0 to 50 mm");
  }
  if (options.terms != kAutomaticTerms && (options.terms < 0 || options.terms > kMostTerms)) {
    throw InputError("the number of inter-scattering terms is " + std::to_string(options.terms) +
                     "; it must be 0 to 1000 (or left out: automatic)");
  }
  if (options.path_lengths < kAutomaticPaths || options.path_lengths > kMostPaths) {
    throw InputError("the number of path lengths is " + std::to_string(options.path_lengths) +
                     "; it must be 1 to " + std::to_string(kMostPaths) + " (or left out: automatic)");
  }
  if (options.gaussian_step < 1 || kGaussianCount % options.gaussian_step != 0 || options.gaussian_step > 6) {
    throw InputError("every " + std::to_string(options.gaussian_step) +
                     "th Gaussian was asked for; it must be every 1st, 2nd, 3rd or 6th");
  }
}

void CheckMaps(const ParameterMaps& maps, int band_count) {
  if (maps[Parameter::kC_m].empty())
    throw InputError("the parameter maps have no pixels; nothing can be rendered");
  for (int i = 0; i < kParameterCount; ++i) {
    const std::string_view name = kParameters[i].name;
    CheckShape(maps.planes[i], name, maps);
    CheckFinite(maps.planes[i], name);
  }
  if (maps.junction_absorbance.empty()) return;
  CheckCount(maps.junction_absorbance.size(), band_count, "junction_absorbance");
  for (const PlaneF& plane : maps.junction_absorbance) {
    CheckShape(plane, "junction_absorbance", maps);
    CheckFinite(plane, "junction_absorbance");
  }
}

void CheckLight(std::span<const PlaneF> light, const ParameterMaps& maps, int band_count) {
  if (light.empty()) return;
  CheckCount(light.size(), band_count, "light");
  for (const PlaneF& plane : light) {
    CheckShape(plane, "light", maps);
    CheckFinite(plane, "light");
  }
}

}  // namespace dermap
