// SPDX-License-Identifier: Apache-2.0
// Maps on their way from one size and set of free parameters to the next.
#pragma once

#include <vector>

#include "fit/patch_problem.h"
#include "fit/scene_choice.h"

namespace dermap {

// Skins from the patch's lightest to its darkest: means of the pixels around two quantiles of melanin.
std::vector<ParameterVector> SkinsOf(const PatchProblem& problem, const ParameterMaps& maps);

// The maps at the problem's size, twice theirs: what they mean over areas is kept.
ParameterMaps Enlarged(const PatchProblem& problem, const ParameterMaps& maps);

// Values of what a candidate does not free.
SkinPoint FixedBy(const Candidate& candidate, SkinPoint fixed);

// The maps with every unknown that is not free at its fixed value.
ParameterMaps WithFixed(const ParameterSpace& space, const ParameterMaps& maps, const SkinPoint& fixed);

// The maps with a plane of the junction: their own, or `absorbance` everywhere.
ParameterMaps WithJunction(ParameterMaps maps, double absorbance);

// A change of one free parameter in one pixel by one scaled unit: planes of what does not change are empty.
ParameterMaps ChangeOfPixel(const ParameterSpace& space, int j, std::size_t pixel, int width, int height);

}  // namespace dermap
