// SPDX-License-Identifier: Apache-2.0
// The fast fit: coarse to fine, and in each size Gauss-Newton steps a pixel whose Jacobian is that of uniform
// skin and whose residual is that of the full render.
#pragma once

#include <functional>
#include <vector>

#include "fit/octave_model.h"
#include "fit/options.h"
#include "fit/patch_problem.h"
#include "fit/run_log.h"

namespace dermap {

// Makes the forward model for a pixel size.
using ModelMaker = std::function<ForwardModel(const ImagingConditions&)>;

struct FastOutcome {
  FitState state;
  bool converged = false;
  BlurTable blur;
  DetailPrior prior;
  std::vector<double> scatter;
  std::vector<PlaneF> variance;  // of each free parameter, scaled units
  double adapted_parameters = 0.0;
};

// `data` at the size wanted; the coarser sizes are made from it. A size costs as many renders as it takes
// iterations. `model` must be that of data.conditions.
FastOutcome FitCoarseToFine(const FitData& data, const ForwardModel& model, const ParameterSpace& space,
                            const ModelMaker& make_model, const FitOptions& options, RunLog& log);

inline constexpr int kCoarsestSize = 32;

}  // namespace dermap
