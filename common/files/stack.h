// SPDX-License-Identifier: Apache-2.0
// Reflectance stacks in spectral OpenEXR (Fichet, Pacanowski, Wilkie, JCGT 2021) and ENVI.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/transport/conditions.h"

namespace dermap {

struct ReflectanceStack {
  std::vector<Band> bands;          // ascending wavelength, at least one
  std::vector<PlaneF> reflectance;  // one a band, fraction; NaN where missing
  std::vector<PlaneF> sigma;        // one standard deviation, one a band, or empty where the file has none
  PlaneF valid;                     // 1 or 0, or empty (all valid)
  // Correlation of the noise of pixels 1, 2, ... apart along x and along y, all bands alike; empty:
  // independent. An average of pixels is known less well than sigma / sqrt(n) where neighbours share
  // photosites.
  std::vector<float> noise_correlation_x, noise_correlation_y;
  std::optional<double> shared_error;  // relative, 0 to 0.1: how well each band as a whole is known
  std::optional<double> pixel_size_mm;
  Illumination illumination = Illumination::kWindow;
  Tape tape = Tape::kFree;
  Geometry geometry = Geometry::kHemispherical;
  std::map<std::string, std::string> notes;  // further string attributes, written as dermap:NAME

  int width() const { return reflectance.empty() ? 0 : reflectance[0].width(); }
  int height() const { return reflectance.empty() ? 0 : reflectance[0].height(); }
};

// Reads .exr or .hdr (ENVI) by extension. Throws InputError.
ReflectanceStack ReadReflectanceStack(const std::filesystem::path& path);
// Writes .exr or .hdr + .img (ENVI) by extension, atomically. Throws StorageError.
void WriteReflectanceStack(const std::filesystem::path& path, const ReflectanceStack& stack);

// "T.450,000000nm" for 450 nm; nullopt for a name that is no such channel of this prefix.
std::string SpectralChannelName(const std::string& prefix, double wavelength_nm);
std::optional<double> WavelengthOfChannel(const std::string& name, const std::string& prefix);

}  // namespace dermap
