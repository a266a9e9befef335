// SPDX-License-Identifier: Apache-2.0
// The test of an assumption where many pixels rest at a bound: there the score says little, and the maps are
// fitted anew to the data as they would be if what was told were another.
#pragma once

#include <vector>

#include "fit/assumptions.h"

namespace dermap {

// Fills `check` (fit/assumptions.h); the junction's absorbance is held at its base value. Nothing can be said
// where a learnt prior links the maps.
void RefitUnder(const std::vector<PlaneF>& answer, const PatchProblem& problem, const FitState& state,
                const DetailView& detail, const SkinPoint& fixed, double test_error, AssumptionCheck& check);

}  // namespace dermap
