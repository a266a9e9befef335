// SPDX-License-Identifier: Apache-2.0
// The fast fit: from coarse to fine, in each size steps that data and prior ask for (fit/octave_solver.h),
// each followed by a full render that says what is left.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "fit/band_check.h"
#include "fit/detail_model.h"
#include "fit/doubts.h"
#include "fit/options.h"
#include "fit/patch_problem.h"
#include "fit/run_log.h"
#include "fit/scene_choice.h"

namespace dermap {

// Makes the forward model for a pixel size.
using ModelMaker = std::function<ForwardModel(const ImagingConditions&)>;

struct FastOutcome {
  FitState state;
  bool converged = false;
  std::vector<Parameter> free;         // as asked for, or chosen
  SkinPoint fixed{};                   // values of what is not free
  std::optional<SuspectBand> suspect;  // its data were divided by 1 + gain_error
  Doubts doubts;
  bool freed_late = false;            // all unknowns at the full size, where what was chosen left too much
  std::vector<Candidate> candidates;  // that were weighed; the first was chosen. Empty: nothing to choose
  DetailModel detail;
  std::vector<FreeVector> spread;      // [octave][free parameter], standard deviations, scaled units
  std::vector<PlaneF> variance;        // of each free parameter, scaled units
  std::vector<PlaneF> noise_variance;  // the same by noise alone; empty where it is the same
  double adapted_parameters = 0.0;     // degrees of freedom of the fitted model
};

// `data` at the size wanted; the coarser sizes are made from it. A size costs as many renders as it takes
// iterations. `model` must be that of data.conditions.
// `data` change where a band's gain is found to be wrong. Without `free` the evidence at the coarsest size
// decides what is free.
FastOutcome FitCoarseToFine(FitData& data, const ForwardModel& model, const std::vector<Parameter>& free,
                            const ModelMaker& make_model, const FitOptions& options, RunLog& log);

inline constexpr int kCoarsestSize = 32;

}  // namespace dermap
