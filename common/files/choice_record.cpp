// SPDX-License-Identifier: Apache-2.0
// Choices as JSON.
#include "common/files/choice_record.h"

#include <nlohmann/json.hpp>

namespace dermap {

nlohmann::ordered_json ChoiceRecord(std::span<const BandChoice> choices, std::span<const Band> bands) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t b = 0; b < choices.size(); ++b) {
    const BandChoice& choice = choices[b];
    list.push_back({{"wavelength_nm", bands[b].wavelength_nm},
                    {"rung", std::string(RungName(choice.rung))},
                    {"epidermis_paths", choice.epidermis_paths},
                    {"dermis_paths", choice.dermis_paths},
                    {"terms", choice.terms},
                    {"margin_mm", choice.margin_mm},
                    {"error", choice.error},
                    {"why", choice.why}});
  }
  return list;
}

}  // namespace dermap
