// SPDX-License-Identifier: Apache-2.0
// Error bars where residuals are larger than elsewhere: beside the edges of bands that do not lie on each
// other, in places that the model does not know.
#pragma once

#include "fit/objective.h"
#include "fit/patch_problem.h"

namespace dermap {

// Multiplies sigma of every pixel by the root of what residuals around it (7 x 7 pixels) scatter beyond
// `expected`, chi2 a datum; by 1 where chance explains it. Pixels without data are left.
void WidenByLocalScatter(const PatchProblem& problem, const Misfit& misfit, double expected,
                         ParameterMaps& sigma);

}  // namespace dermap
