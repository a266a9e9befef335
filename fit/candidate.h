// SPDX-License-Identifier: Apache-2.0
// A set of free parameters that was weighed against others.
#pragma once

#include <string>
#include <vector>

#include "common/tissue/parameters.h"

namespace dermap {

// A set of free parameters; the others are at the mean of average skin (the junction at its base value), or
// absent: 0.
struct Candidate {
  std::vector<Parameter> free, absent;
  double log_evidence = 0.0;  // over that of the best candidate: 0 or less
};

// "C_m, beta_m".
std::string NamesOf(const std::vector<Parameter>& parameters);

}  // namespace dermap
