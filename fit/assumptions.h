// SPDX-License-Identifier: Apache-2.0
// What a fit is told and cannot put right: how large a pixel is, how thick the epidermis. A wrong value moves
// the maps, and what maps cannot make up for stays in the residuals, where it is looked for.
#pragma once

#include <string_view>
#include <vector>

#include "fit/detail_model.h"
#include "fit/octave_levels.h"

namespace dermap {

enum class Assumption { kPixelSize, kThickness };

struct AssumptionCheck {
  Assumption assumption = Assumption::kPixelSize;
  double log_error = 0.0;          // logarithm of the true value over the told one, as the residuals have it
  double sigma = 0.0;              // one standard deviation of that, the test's own error included
  double log_evidence = 0.0;       // logarithm by which the data prefer it to be wrong
  double log_evidence_seen = 0.0;  // the same by no more than the test's own error allows
  std::vector<PlaneF> maps;  // of each free parameter, if it is: scaled units; empty: nothing can be said
};

// Answers of the logarithm of reflectance, one plane a band, to the logarithm of what was told; nothing where
// renders would have to be more exact to see any.
std::vector<PlaneF> AnswerToPixelSize(const PatchProblem& problem, const FitState& state);
std::vector<PlaneF> AnswerToThickness(const PatchProblem& problem, const FitState& state,
                                      std::string_view profiles);

// The score test of one assumption at the optimum: residuals against the part of `answer` that maps cannot
// make up for. The junction's absorbance, which can take over much of a wrong thickness, is for that held at
// its base value: what the evidence then says is against a fit without it.
// `test_error`: one standard deviation of the test itself, logarithm.
AssumptionCheck CheckAssumption(Assumption assumption, const std::vector<PlaneF>& answer,
                                const PatchProblem& problem, const FitState& state, const DetailView& detail,
                                const SkinPoint& fixed, double test_error);

}  // namespace dermap
