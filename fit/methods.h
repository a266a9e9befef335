// SPDX-License-Identifier: Apache-2.0
// The three methods, and what each leaves behind.
#pragma once

#include <optional>
#include <vector>

#include "fit/fast.h"

namespace dermap {

// What a method leaves behind.
struct MethodOutcome {
  std::vector<Parameter> free;
  FitState state;
  bool converged = false;
  std::optional<double> adapted_parameters;  // where it was measured
  std::vector<PlaneF> variance;        // of each free parameter, scaled units; empty: from single pixels
  std::vector<PlaneF> noise_variance;  // the same by noise alone, where that is much less
  // Likewise; whether a pixel is identifiable goes by it. Empty: by `variance`.
  std::vector<PlaneF> telling_variance;
  bool grossly_told = false;  // what was told is far from what the data speak for
  double scatter = 1.0;       // of residuals over noise that `variance` holds already
  std::vector<Candidate> candidates;
};

// `data` change where a band's gain is found to be wrong.
MethodOutcome RunFast(FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                      const FitOptions& options, RunLog& log);
MethodOutcome RunDescent(const FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                         const std::vector<Parameter>& free, const FitOptions& options, RunLog& log);
// The reference takes over what the fast fit found to be free, and how much detail there is. On small patches
// it starts where the fast fit starts, from the closed-form inversion; on others, where gradients alone lead,
// from the fast fit's maps, whose objective it can only lower.
MethodOutcome RunReference(FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                           const FitOptions& options, RunLog& log);

}  // namespace dermap
