// SPDX-License-Identifier: Apache-2.0
// A scene of the ladder study as JSON, for its journal and its results, and in words.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/files/choice_record.h"
#include "studies/ladder_study.h"

namespace dermap {

nlohmann::json LadderRecord(const LadderScene& scene) {
  nlohmann::json json{{"scene", scene.name},
                      {"tolerance", scene.tolerance},
                      {"seconds", scene.seconds},
                      {"times_faster", scene.times_faster},
                      {"ratio_spread", scene.ratio_spread},
                      {"faster_than_reference", scene.faster_than_reference},
                      {"error", scene.error},
                      {"estimate", scene.estimate},
                      {"bands", nlohmann::json::array()}};
  for (const LadderBand& band : scene.bands) {
    const Band centre{band.wavelength_nm, 0.0};
    nlohmann::json entry = ChoiceRecord({&band.choice, 1}, {&centre, 1})[0];
    entry["estimate"] = band.choice.error;
    entry["error"] = band.error;
    json["bands"].push_back(entry);
  }
  return json;
}

LadderScene LadderSceneFrom(const nlohmann::json& json) {
  LadderScene scene;
  scene.name = json.at("scene");
  scene.tolerance = json.at("tolerance");
  scene.seconds = json.at("seconds");
  scene.times_faster = json.at("times_faster");
  scene.ratio_spread = json.at("ratio_spread");
  scene.faster_than_reference = json.at("faster_than_reference");
  scene.error = json.at("error");
  scene.estimate = json.at("estimate");
  for (const nlohmann::json& entry : json.at("bands")) {
    LadderBand& band = scene.bands.emplace_back();
    band.wavelength_nm = entry.at("wavelength_nm");
    for (const Rung rung : {Rung::kLocal, Rung::kHomogeneous, Rung::kFirstOrder, Rung::kFull})
      if (entry.at("rung") == RungName(rung)) band.choice.rung = rung;
    band.choice.epidermis_paths = entry.at("epidermis_paths");
    band.choice.dermis_paths = entry.at("dermis_paths");
    band.choice.terms = entry.at("terms");
    band.choice.margin_mm = entry.at("margin_mm");
    band.choice.error = entry.at("estimate");
    band.choice.why = entry.at("why");
    band.error = entry.at("error");
  }
  return scene;
}

std::string RungsInWords(const LadderScene& scene) {
  std::string words;
  for (const Rung rung : {Rung::kLocal, Rung::kHomogeneous, Rung::kFirstOrder, Rung::kFull}) {
    const auto count = std::count_if(scene.bands.begin(), scene.bands.end(),
                                     [&](const LadderBand& band) { return band.choice.rung == rung; });
    if (count > 0) words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count, RungName(rung));
  }
  return words;
}

}  // namespace dermap
