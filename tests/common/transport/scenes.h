// SPDX-License-Identifier: Apache-2.0
// Scenes, tables and measures that the transport tests share.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/transport/forward_model.h"

namespace dermap {

const Chromophores& TestChromophores();
const ProfileSource& TestSource(const std::string& name = "multipole");
// Tables at one wavelength of average tissue, built once a test program.
const BandTables& TestTables(double wavelength_nm, const std::string& source = "multipole");

// A patch of 7.5 mm.
ImagingConditions Conditions(int size, Illumination illumination);
ForwardModel Model(std::span<const Band> bands, const ImagingConditions& conditions,
                   const ForwardOptions& options = {}, const std::string& source = "multipole");

// Light skin with soft-edged freckles and redder spots, at the scale of a 256 x 256 patch of 7.5 mm whatever
// the size.
ParameterMaps FreckledSkin(int size, std::uint32_t seed);
// Independent values in every pixel.
PlaneF Noise(int width, int height, std::uint32_t seed, float low, float high);

struct Difference {
  double relative_rms = 0.0;  // rms over the mean of `reference`
  double relative_max = 0.0;  // largest difference over the mean of `reference`
};
Difference Compare(const PlaneF& found, const PlaneF& reference);

}  // namespace dermap
