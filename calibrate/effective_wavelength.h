// SPDX-License-Identifier: Apache-2.0
// From the wavelength at which the sensor has seen a band to the centre of its filter.
#pragma once

#include <vector>

#include "calibrate/band_frames.h"
#include "common/files/stack.h"

namespace dermap {

// Brings each band from the wavelength at which the sensor, on average, has seen it to the filter's centre.
void CorrectEffectiveWavelengths(const Session& session, const StepSet& skip, std::vector<BandFrames>& bands,
                                 ReflectanceStack& stack);

}  // namespace dermap
