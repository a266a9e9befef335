// SPDX-License-Identifier: Apache-2.0
// For tests: spectra of skin by adding-doubling, which shares no optics with the model that is tested.
#pragma once

#include <vector>

#include "fit/spectra/measured_skin.h"
#include "fit/spectra/spectrum_model.h"

namespace dermap {

const Chromophores& TestChromophores();
std::vector<double> TestWavelengths();      // 400 to 720 nm by 10 nm
const SpectrumModel& MonochromaticModel();  // no aperture, no width; made once

// Bare tissue (SkinModels' core) with these values in place.
SkinVector SkinWith(std::initializer_list<std::pair<SkinParameter, double>> values);

// [D08 eq. 10-12] and the packing of blood, written once more; optics by tests/reference.
std::vector<double> MadeSpectrum(const SkinVector& skin, const std::vector<double>& wavelengths_nm);

}  // namespace dermap
