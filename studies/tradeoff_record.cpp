// SPDX-License-Identifier: Apache-2.0
// A point of the tradeoff study as JSON, for its journal and its results.
#include <nlohmann/json.hpp>

#include "studies/tradeoff_points.h"

namespace dermap {

nlohmann::json ToJson(const TradeoffPoint& p) {
  nlohmann::json json{{"kind", p.kind},
                      {"scene", p.scene},
                      {"setting", p.setting},
                      {"family", p.family},
                      {"options", p.options},
                      {"size", p.size},
                      {"seconds", p.seconds},
                      {"ratio_to_default", p.ratio},
                      {"ratio_spread", p.ratio_spread},
                      {"pairs", p.pairs},
                      {"default", p.is_default},
                      {"paper", p.is_paper},
                      {"extrapolated", p.extrapolated},
                      {"error", p.error},
                      {"error_bar", p.error_bar}};
  if (p.error_monte_carlo > 0.0) {
    json["error_monte_carlo"] = p.error_monte_carlo;
    json["monte_carlo_bar"] = p.monte_carlo_bar;
  }
  if (p.kind == "fit") {
    json["error_reference"] = p.error_reference;
    json["reference_bar"] = p.reference_bar;
    json["chi2"] = p.chi2;
    json["renders"] = p.renders;
    for (int k = 0; k < kParameterCount; ++k) {
      const std::string name(kParameters[k].name);
      json["error_to_truth"][name] = p.to_truth[k];
      json["error_to_reference"][name] = p.to_reference[k];
      json["noise_bound"][name] = p.bound[k];
    }
  }
  return json;
}

TradeoffPoint TradeoffPointFromJson(const nlohmann::json& json) {
  TradeoffPoint p;
  p.kind = json.at("kind");
  p.scene = json.at("scene");
  p.setting = json.at("setting");
  p.family = json.at("family");
  p.options = json.at("options");
  p.size = json.at("size");
  p.seconds = json.at("seconds");
  p.ratio = json.at("ratio_to_default");
  p.ratio_spread = json.at("ratio_spread");
  p.pairs = json.at("pairs");
  p.is_default = json.at("default");
  p.is_paper = json.at("paper");
  p.extrapolated = json.at("extrapolated");
  p.error = json.at("error");
  p.error_bar = json.at("error_bar");
  p.error_monte_carlo = json.value("error_monte_carlo", 0.0);
  p.monte_carlo_bar = json.value("monte_carlo_bar", 0.0);
  p.error_reference = json.value("error_reference", 0.0);
  p.reference_bar = json.value("reference_bar", 0.0);
  p.chi2 = json.value("chi2", 0.0);
  p.renders = json.value("renders", 0);
  for (int k = 0; k < kParameterCount && p.kind == "fit"; ++k) {
    const std::string name(kParameters[k].name);
    p.to_truth[k] = json.at("error_to_truth").at(name);
    p.to_reference[k] = json.at("error_to_reference").at(name);
    p.bound[k] = json.at("noise_bound").at(name);
  }
  return p;
}

}  // namespace dermap
