// SPDX-License-Identifier: Apache-2.0
// Verdicts for people's and programs' eyes.
#include "studies/verdict.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace dermap {

bool AllHold(const std::vector<Verdict>& verdicts) {
  return std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.holds(); });
}

nlohmann::json VerdictsAsJson(const std::vector<Verdict>& verdicts) {
  nlohmann::json list = nlohmann::json::array();
  for (const Verdict& v : verdicts)
    list.push_back({{"claim", v.claim}, {"worst", v.worst}, {"limit", v.limit}, {"holds", v.holds()}});
  return list;
}

}  // namespace dermap
