// SPDX-License-Identifier: Apache-2.0
// Bands that hold the same picture: a file taken for two, or a wheel that stood still.
#pragma once

#include <string>
#include <vector>

#include "fit/prepare.h"

namespace dermap {

// Finds bands whose values are those of another one, exactly or times one factor; two wavelengths never look
// alike to the last digit, and no two frames have the same noise. Of two of one wavelength the second is left
// out, of two wavelengths both, as nobody can tell whose picture it is. Says so in `decisions`.
void LeaveOutCopies(FitData& data, std::vector<std::string>& decisions);

}  // namespace dermap
