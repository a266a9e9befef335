// SPDX-License-Identifier: Apache-2.0
// Small simulated patches for the tests of the fit: maps, their render, and noise.
//
// Scene and fit share one forward model, so these tests prove the optimiser and the bookkeeping, never the
// physics: that is judged by the independent Monte Carlo in tests/reference.
#pragma once

#include <cstdint>
#include <vector>

#include "common/files/stack.h"
#include "common/optics/profile_source.h"
#include "common/tissue/tissue.h"
#include "common/transport/forward_model.h"
#include "fit/prepare.h"

namespace dermap::testing {

const Chromophores& TestChromophores();
ForwardModel MakeModel(const std::vector<Band>& bands, const ImagingConditions& conditions);

// Monochromatic bands: their tables build fastest. The wavelengths of the simulated rig, or every second of
// them.
std::vector<Band> EightBands();
std::vector<Band> FourBands();
ImagingConditions Window(double pixel_size_mm);   // lit through a window, as from the rig
ImagingConditions Uniform(double pixel_size_mm);  // lit everywhere

// Light or medium skin with smooth variation of every parameter and one darker spot.
ParameterMaps SpottedSkin(int size, double melanin);

// The render with Gaussian noise of `relative_noise`, sigma stated.
ReflectanceStack NoisyStack(const ForwardModel& model, const ParameterMaps& maps, double relative_noise,
                            std::uint64_t seed);

// PrepareStack for all five parameters, its sentences dropped.
FitData Prepared(const ReflectanceStack& stack, int free_count = kParameterCount);

std::vector<Parameter> AllParameters();
double MedianRelativeError(const PlaneF& found, const PlaneF& truth);

}  // namespace dermap::testing
