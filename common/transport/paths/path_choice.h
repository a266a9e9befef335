// SPDX-License-Identifier: Apache-2.0
// How much model a band of a scene needs for a given tolerance.
#pragma once

#include "common/optics/path_kernels.h"
#include "common/transport/band_optics.h"
#include "common/transport/paths/path_plan.h"

namespace dermap {

// What of a scene decides.
struct SceneRange {
  AbsorptionRange epidermis, dermis;
  double most_transmittance = 1.0;  // of the junction
  bool uniform_besides = false;     // junction and light are the same everywhere
};

// `tables` and `totals` are the centre's; reduced scattering in 1/mm. Path lengths are not chosen yet: they
// come with their kernels (PathPlan), whose error is added to the estimate.
BandChoice ChooseModel(const BandTables& tables, const LocalTotals& totals, double mu_s_dermis,
                       const SceneRange& scene, bool black_tape, const ImagingConditions& conditions,
                       const ForwardOptions& options, int most_terms);
// Completes it.
void AddPaths(const PathPlan& plan, const PathFrames& frames, double tolerance, BandChoice& choice);
// One sentence.
std::string Explain(const BandChoice& choice, bool window);

}  // namespace dermap
