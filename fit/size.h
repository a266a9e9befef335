// SPDX-License-Identifier: Apache-2.0
// How large a fit may be within its time budget.
#pragma once

#include <string>
#include <vector>

#include "fit/options.h"

namespace dermap {

// Renders that a fit will probably take, at its final size.
double ExpectedRenders(const FitOptions& options, int free_count);

// The largest of `longer_side`, 256, 128, 64 and 32 (those below longer_side) at which `renders` renders stay
// within the budget; the smallest where none does. `seconds_per_pixel`: of one render of all bands, per pixel
// of the patch, where patches are `patch_aspect` (shorter by longer side). Says in `decisions` what it chose
// and why.
int LargestAffordableSize(int longer_side, double patch_aspect, double seconds_per_pixel, double renders,
                          double time_budget_s, std::vector<std::string>& decisions);

}  // namespace dermap
