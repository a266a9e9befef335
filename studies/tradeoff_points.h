// SPDX-License-Identifier: Apache-2.0
// The settings of the tradeoff study, and how one is measured on one scene.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "fit/options.h"
#include "studies/tradeoff_study.h"

namespace dermap {

struct RenderSetting {
  std::string name, family;
  std::string profiles = "exact";
  ForwardOptions forward{};
  int size = 0;       // of the render; the study's or less
  double cost = 1.0;  // rough, in renders by the default: for the time left
  bool is_default = false, is_paper = false;
};
std::vector<RenderSetting> RenderSettings(int size, bool quick);
std::vector<std::string> RenderScenes(bool quick);

struct FitSetting {
  std::string name, family;
  FitOptions options{};
  double cost = 1.0;  // rough, in fits by the default
  bool is_default = false, is_paper = false;
};
std::vector<FitSetting> FitSettings(int size, bool quick);
std::vector<std::string> FitScenes(bool quick);

// What every fit of the study is compared with: the slowest and most exact that there is.
FitOptions ReferenceFit(int size);

// Measures; keeps the references of the scene that it saw last.
class TradeoffMeter {
 public:
  TradeoffMeter(int size, std::uint64_t seed, double budget_s);
  ~TradeoffMeter();
  TradeoffPoint Render(const RenderSetting& setting, const std::string& scene);
  TradeoffPoint Fit(const FitSetting& setting, const std::string& scene);
  // What single precision does to the default render's light: a third of the light, times three, against all
  // of it; relative rms, largest of the bands.
  double Rounding(const std::string& scene);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

nlohmann::json ToJson(const TradeoffPoint& point);
TradeoffPoint TradeoffPointFromJson(const nlohmann::json& json);

}  // namespace dermap
