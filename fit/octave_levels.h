// SPDX-License-Identifier: Apache-2.0
// The patch near a state as a linear model: what the data still ask for and how reflectance answers to the
// parameters, at the pixels themselves and at every coarser octave.
#pragma once

#include <vector>

#include "fit/octaves.h"
#include "fit/patch_problem.h"

namespace dermap {

struct OctaveLevel {
  GridShape shape;
  // Relative, of all data of a band: that of the data (FitData), and half of what renders may be off.
  double shared_error = 0.0;
  double noise_inflation = 1.0;  // of a mean's variance, by the correlation of neighbours' noise
  // By band. The logarithms' residuals (weighted means of the pixels below) and 1 / variance of them;
  // derivatives of the logarithm of uniform skin's reflectance (LogSensitivity).
  std::vector<PlaneF> residual, weight;
  std::vector<PlaneF> epidermis, dermis, junction;  // `junction` is empty where it is not free
  // By free parameter, scaled units. Details of the last level, a single pixel: distance from average skin.
  std::vector<PlaneF> position, detail;
};

// Finest first, down to a single pixel. `shared_error`: FitData's own, or what error bars allow for.
std::vector<OctaveLevel> LineariseInOctaves(const PatchProblem& problem, const FitState& state,
                                            double shared_error);
inline std::vector<OctaveLevel> LineariseInOctaves(const PatchProblem& problem, const FitState& state) {
  return LineariseInOctaves(problem, state, problem.data().shared_error);
}
// Makes the residuals of all levels anew from those of the finest.
void CoarsenResiduals(std::vector<OctaveLevel>& levels);

}  // namespace dermap
