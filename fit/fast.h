// SPDX-License-Identifier: Apache-2.0
// The fast fit: coarse to fine, and in each size Gauss-Newton steps a pixel whose Jacobian is that of uniform
// skin and whose residual is that of the full render.
#pragma once

#include <functional>
#include <vector>

#include "fit/options.h"
#include "fit/patch_problem.h"
#include "fit/run_log.h"

namespace dermap {

// Makes the forward model for a pixel size.
using ModelMaker = std::function<ForwardModel(const ImagingConditions&)>;

struct FastOutcome {
  FitState state;
  bool converged = false;
  std::vector<int> steps;  // taken in each size, coarsest first
};

// `data` at the size wanted; the coarser sizes are made from it. A size costs as many renders as it takes
// iterations. `model` must be that of data.conditions. With `steps` (of an earlier outcome) each size takes
// just as many, whatever they bring: so the same linear map is applied to other data.
FastOutcome FitCoarseToFine(const FitData& data, const ForwardModel& model, const ParameterSpace& space,
                            const ModelMaker& make_model, const FitOptions& options, RunLog& log,
                            const std::vector<int>* steps = nullptr);

// Degrees of freedom of the fitted model: how far predictions follow noise in their own datum, sum of d
// predicted_i / d measured_i, estimated by one more fit to data with half a standard deviation added or taken
// away at random (generalised degrees of freedom: J. Ye, J. Am. Stat. Assoc. 93, 1998). Counting free
// parameters instead would count detail that the blur of the skin hides and priors decide.
double AdaptedParameters(const FitData& data, const ForwardModel& model, const ParameterSpace& space,
                         const ModelMaker& make_model, const FitOptions& options, const FastOutcome& outcome,
                         RunLog& log);

// How closely a finer size is held to the coarser solution, in scaled units: its standard deviation there.
inline constexpr double kDetailSigma = 0.25;
inline constexpr int kCoarsestSize = 32;

}  // namespace dermap
