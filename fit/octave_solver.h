// SPDX-License-Identifier: Apache-2.0
// The maps that data and prior ask for near a state, octave by octave of detail, and how sure they are.
//
// Maps are taken as a mean plus details of every octave (fit/octaves.h). What is known before the data is how
// much detail a parameter has in each octave: a Gaussian prior whose variances are not assumed but estimated
// from the data themselves (empirical Bayes: D. J. C. MacKay, Neural Computation 4, 1992). So what the data
// cannot tell from noise, or what skin's blur hides, is not followed, and a parameter that does not vary in a
// scene becomes one number for all of it. Solved from the mean to the finest detail: in each octave a pixel
// answers by itself, with the Jacobian of uniform skin times the share of detail that the blur leaves
// (fit/blur_share.h), to what coarser octaves have not answered. No render.
#pragma once

#include <vector>

#include "fit/detail_model.h"
#include "fit/octave_rows.h"

namespace dermap {

struct OctaveStep {
  std::vector<PlaneF> change;                // of each free parameter, scaled units
  std::vector<PlaneF> variance;              // of each free parameter once the step is taken, scaled units
  std::vector<DetailStatistics> statistics;  // [octave], once the step is taken
  double adapted_parameters = 0.0;           // that the data decide: degrees of freedom of the fitted model
  double move = 0.0;                         // rms of the change in standard deviations
};

// Details of a plane span three quarters of its pixels' dimensions, so a detail of variance v a pixel has
// 4/3 v in each of them.
inline constexpr double kDetailShare = 0.75;

OctaveStep SolveInOctaves(const PatchProblem& problem, const std::vector<OctaveLevel>& levels,
                          const DetailView& model, const SkinPoint& fixed);

// The maps changed by `share` of the step, within bounds; masked pixels are left.
ParameterMaps Apply(const PatchProblem& problem, const ParameterMaps& maps, const OctaveStep& step,
                    double share = 1.0);

}  // namespace dermap
