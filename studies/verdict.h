// SPDX-License-Identifier: Apache-2.0
// What a study asserts: the largest value that it met, and the limit.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace dermap {

struct Verdict {
  std::string claim;
  double worst = 0.0, limit = 0.0;
  bool holds() const { return worst <= limit; }
};

bool AllHold(const std::vector<Verdict>& verdicts);
// A list of {claim, worst, limit, holds}.
nlohmann::json VerdictsAsJson(const std::vector<Verdict>& verdicts);

}  // namespace dermap
