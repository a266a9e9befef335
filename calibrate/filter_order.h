// SPDX-License-Identifier: Apache-2.0
// Whether each band's frames have the colours that its filter gives on this camera, where the rig states the
// camera's and the flash's curves: a wheel that is a slot off gives itself away.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calibrate/band_frames.h"
#include "common/files/rig.h"
#include "common/spectra/sampled_spectrum.h"

namespace dermap {

struct SpectralCurves {
  std::array<SampledSpectrum, 3> camera;  // red, green, blue
  SampledSpectrum flash;
};
// nullopt where the rig names none.
std::optional<SpectralCurves> ReadSpectralCurves(const RigConfig& rig);

// Light of each lattice through a filter, relative.
std::array<double, kLatticeCount> ColoursOfFilter(const SpectralCurves& curves, const Band& band,
                                                  const std::array<char, kLatticeCount>& colours);

// Mean wavelength of a band as the sensor weighs it: each lattice in proportion to its signal, as photon
// noise weighs them.
double EffectiveWavelength(const SpectralCurves& curves, const Band& band,
                           const std::array<double, kLatticeCount>& signals,
                           const std::array<char, kLatticeCount>& colours);

// Throws InputError naming the band whose colours are those of another filter of the rig.
void CheckFilterOrder(const RigConfig& rig, const std::array<char, kLatticeCount>& colours,
                      const std::vector<BandFrames>& bands);

}  // namespace dermap
