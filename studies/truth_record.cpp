// SPDX-License-Identifier: Apache-2.0
// Points of the truth study as JSON, for its journal and its results.
#include <nlohmann/json.hpp>

#include "studies/point_journal.h"
#include "studies/truth_point.h"

namespace dermap {
nlohmann::json ToJson(const TruthPoint& point) {
  nlohmann::json parameters;
  for (std::size_t k = 0; k < point.parameters.size(); ++k) {
    const TruthParameter& p = point.parameters[k];
    parameters[std::string(InfoOf(static_cast<Parameter>(k)).name)] = {
        {"free", p.free},         {"error", p.error},           {"bound", p.bound},
        {"told", p.identifiable}, {"over_bound", p.over_bound}, {"claimed", p.claimed},
        {"spread", p.spread},     {"covered", p.covered}};
  }
  return {{"scene", point.scene}, {"free", point.free}, {"chosen", point.chosen},  {"size", point.size},
          {"draws", point.draws}, {"chi2", point.chi2}, {"parameters", parameters}};
}

TruthPoint TruthPointFromJson(const nlohmann::json& json) {
  TruthPoint point;
  point.scene = json.at("scene");
  point.free = json.at("free");
  point.chosen = json.at("chosen");
  point.size = json.at("size");
  point.draws = json.at("draws");
  point.chi2 = NumberOrNaN(json.at("chi2"));
  for (std::size_t k = 0; k < point.parameters.size(); ++k) {
    const nlohmann::json& from =
        json.at("parameters").at(std::string(InfoOf(static_cast<Parameter>(k)).name));
    TruthParameter& p = point.parameters[k];
    p.free = from.at("free");
    p.error = NumberOrNaN(from.at("error"));
    p.bound = NumberOrNaN(from.at("bound"));
    p.identifiable = NumberOrNaN(from.at("told"));
    p.over_bound = NumberOrNaN(from.at("over_bound"));
    p.claimed = NumberOrNaN(from.at("claimed"));
    p.spread = NumberOrNaN(from.at("spread"));
    for (std::size_t i = 0; i < p.covered.size(); ++i) p.covered[i] = NumberOrNaN(from.at("covered").at(i));
  }
  return point;
}

nlohmann::json ToJson(const MonteCarloFit& fit) {
  return {{"bands", fit.bands},
          {"melanin_bias", fit.melanin_bias},
          {"melanin_median", fit.melanin_median},
          {"melanin_decile", fit.melanin_decile},
          {"blood_bias", fit.blood_bias},
          {"blood_median", fit.blood_median},
          {"blood_known", fit.blood_known}};
}

MonteCarloFit MonteCarloFitFromJson(const nlohmann::json& json) {
  return {.bands = json.at("bands"),
          .melanin_bias = NumberOrNaN(json.at("melanin_bias")),
          .melanin_median = NumberOrNaN(json.at("melanin_median")),
          .melanin_decile = NumberOrNaN(json.at("melanin_decile")),
          .blood_bias = NumberOrNaN(json.at("blood_bias")),
          .blood_median = NumberOrNaN(json.at("blood_median")),
          .blood_known = NumberOrNaN(json.at("blood_known"))};
}

}  // namespace dermap
