// SPDX-License-Identifier: Apache-2.0
// Stacks that others have calibrated already: TIFF (pages, channels or files as bands) and ENVI, brought into
// our layout with what their files do not say.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "common/files/stack.h"

namespace dermap {

struct ImportOptions {
  std::vector<double> wavelengths_nm;  // in the files' order; empty: as an ENVI header says
  std::vector<double> fwhm_nm;  // one for all, or one a band; empty: as the file says, or monochromatic
  std::optional<double> scale;  // reflectance a unit; default: integers by their type's range, floats 1
  std::optional<double> pixel_size_mm;
  std::optional<double> relative_sigma;  // one standard deviation, of the reflectance
  std::optional<Illumination> illumination;
  std::optional<Tape> tape;
  std::optional<Geometry> geometry;
};

// Bands come out by ascending wavelength. Throws InputError naming the file: unreadable, another shape than
// the first, a number of planes that is not that of the wavelengths.
ReflectanceStack ImportStack(const std::vector<std::filesystem::path>& inputs, const ImportOptions& options);

}  // namespace dermap
