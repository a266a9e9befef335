// SPDX-License-Identifier: Apache-2.0
// Which parameters a scene's data carry: no more are freed than the evidence asks for.
#pragma once

#include <vector>

#include "fit/candidate.h"
#include "fit/detail_model.h"
#include "fit/patch_problem.h"

namespace dermap {

// C_m, beta_m, C_he, C_bc, C_hd and the junction's absorbance: what a choice starts from.
std::vector<Parameter> AllUnknowns();

// Chooses among the unknowns that are free in `problem`, whose fit rests at `state`. The evidence is that of
// the linear model with its Gaussian priors, where it can be had exactly for any set without another fit: for
// each octave and pixel, with N the normal matrix, b what the data ask for and S the prior's variances,
// (b' (N + 1/S)^-1 b - ln det(1 + S N)) / 2. Ink at the junction is weighed first, at the variances of the
// fit; the others at those that make the data likeliest. They are given up one after the other, the least
// missed first: where the data tell the patch's mean for a gain in evidence, where they do not, or as absent,
// while it costs no more than kEvidenceForOne, and anyhow while there are more than `most`; melanin, which
// all skin has, stays free. Returns the sets that were looked at, best evidence first within the path taken;
// the chosen one is the first.
std::vector<Candidate> ChooseCandidates(const PatchProblem& problem, const FitState& state,
                                        const DetailView& detail, const SkinPoint& fixed, int most);

// Logarithm of the evidence that an unknown must bring to be free: e^3 = 20 to 1.
inline constexpr double kEvidenceForOne = 3.0;

// Whether the chosen set may be smaller than skin needs: no more bands than unknowns, or evidence lost.
bool LacksBands(const std::vector<Candidate>& candidates, int band_count);

}  // namespace dermap
