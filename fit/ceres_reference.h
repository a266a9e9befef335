// SPDX-License-Identifier: Apache-2.0
// The reference: Ceres finds the minimum of the exact objective (fit/posterior.h), from gradients alone for
// any size, from the dense Jacobian for small patches.
#pragma once

#include <vector>

#include "fit/posterior.h"
#include "fit/run_log.h"

namespace dermap {

struct ReferenceOutcome {
  ParameterMaps maps;
  bool converged = false;
  double objective = 0.0;
  int evaluations = 0;           // of value and gradient, or of value and Jacobian
  std::vector<PlaneF> variance;  // of each free parameter, scaled units; of MinimiseDense only
};

// L-BFGS over details of all octaves, each in units of how far it is known: `spread`, [octave][free
// parameter], standard deviations in scaled units. So steps of one length suit all of them.
ReferenceOutcome MinimiseByGradient(const Posterior& posterior, const ParameterMaps& start,
                                    const std::vector<FreeVector>& spread, int max_iterations, RunLog& log);

// Levenberg-Marquardt within the bounds, with the exact Jacobian of all pixels by all parameters (a product
// with the Jacobian for each of them), and the variances from its normal matrix.
ReferenceOutcome MinimiseDense(const Posterior& posterior, const DetailView& detail,
                               const ParameterMaps& start, int max_iterations, RunLog& log);

inline constexpr int kDensePixels = 144;  // a patch of no more is small: a minute

}  // namespace dermap
