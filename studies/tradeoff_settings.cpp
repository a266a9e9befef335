// SPDX-License-Identifier: Apache-2.0
// Which settings and scenes the tradeoff study goes through.
#include <fmt/format.h>

#include "studies/tradeoff_points.h"

namespace dermap {
namespace {

constexpr const char* kLowRank = "lowrank, both ends (default engine)";
constexpr const char* kGatherFamily = "lowrank, exit alone";
constexpr const char* kGaussians = "Gaussians: cascade, pyramid";
constexpr const char* kPublished = "published optics (multipole)";

RenderSetting Setting(std::string name, const char* family, int size) {
  RenderSetting setting;
  setting.name = std::move(name);
  setting.family = family;
  setting.size = size;
  return setting;
}

void AddLowRank(std::vector<RenderSetting>& list, int size, bool quick) {
  const double shipped = ForwardOptions{}.tolerance;
  for (const double tolerance : quick ? std::vector<double>{1e-2, 1e-3, 1e-4}
                                      : std::vector<double>{1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4}) {
    auto& s = list.emplace_back(Setting(fmt::format("tolerance {:g}", tolerance), kLowRank, size));
    s.forward.tolerance = tolerance;
    s.is_default = tolerance == shipped;
    if (s.is_default) s.name = "default";
  }
  for (const int terms : quick ? std::vector<int>{1} : std::vector<int>{0, 1, 2, 5, 10}) {
    auto& s = list.emplace_back(Setting(fmt::format("{} terms", terms), kLowRank, size));
    s.forward.terms = terms;
  }
  for (const int divisor : quick ? std::vector<int>{2} : std::vector<int>{2, 4})
    list.push_back(Setting(fmt::format("{} px", size / divisor), kLowRank, size / divisor));
  for (const double tolerance : quick ? std::vector<double>{1e-3} : std::vector<double>{1e-2, 1e-3, 1e-4}) {
    auto& s = list.emplace_back(Setting(fmt::format("exit alone, {:g}", tolerance), kGatherFamily, size));
    s.forward.coupling = Coupling::kGather;
    s.forward.tolerance = tolerance;
  }
}

}  // namespace

std::vector<RenderSetting> RenderSettings(int size, bool quick) {
  std::vector<RenderSetting> list;
  AddLowRank(list, size, quick);
  for (const Engine engine : {Engine::kPyramid, Engine::kCascade}) {
    for (const int divisor : {1, 4}) {
      if (quick && divisor > 1) continue;
      const std::string name(EngineName(engine));
      auto& s = list.emplace_back(Setting(divisor > 1 ? fmt::format("{}, {} px", name, size / divisor) : name,
                                          kGaussians, size / divisor));
      s.forward.engine = engine;
    }
  }
  for (const char* profiles : {"multipole", "multipole-symmetric"}) {
    if (quick && std::string(profiles) != "multipole") continue;
    auto& s = list.emplace_back(Setting(profiles, kPublished, size));
    s.profiles = profiles;
  }
  auto& paper = list.emplace_back(Setting("the paper", kPublished, size));  // [D08 4]: 18 blurs, 5 terms
  paper.profiles = "multipole";
  paper.forward.engine = Engine::kCascade;
  paper.forward.coupling = Coupling::kGather;
  paper.forward.terms = 5;
  paper.forward.close_series = false;
  paper.is_paper = true;
  return list;
}

std::vector<std::string> RenderScenes(bool quick) {
  if (quick) return {"light", "monte_carlo_skin"};
  return {"light_freckles", "medium_vein", "dark", "step", "tattoo", "monte_carlo_skin"};
}

std::vector<FitSetting> FitSettings(int size, bool quick) {
  std::vector<FitSetting> list;
  const auto add = [&](std::string name, const char* family) -> FitSetting& {
    FitSetting& s = list.emplace_back();
    s.name = std::move(name);
    s.family = family;
    s.options.size = size;
    s.options.time_budget_s = 1e6;
    return s;
  };
  add("default", "fast (default method)").is_default = true;
  add(fmt::format("{} px", size / 2), "fast (default method)").options.size = size / 2;
  for (const double tolerance : quick ? std::vector<double>{1e-2} : std::vector<double>{1e-2, 3e-3, 3e-4})
    add(fmt::format("tolerance {:g}", tolerance), "fast (default method)").options.tolerance = tolerance;
  if (!quick) {
    add(fmt::format("{} px", size / 4), "fast (default method)").options.size = size / 4;
    add("exit alone", "fast, other engines").options.forward.coupling = Coupling::kGather;
    add("cascade", "fast, other engines").options.forward.engine = Engine::kCascade;
  }
  add("pyramid", "fast, other engines").options.forward.engine = Engine::kPyramid;
  add("multipole", "fast, published optics").options.profiles = "multipole";
  if (!quick) add("multipole-symmetric", "fast, published optics").options.profiles = "multipole-symmetric";
  FitSetting& descent = add(fmt::format("descent, {} px", size / 4), "descent");
  descent.options.method = FitMethod::kDescent;
  descent.options.start = StartPoint::kLocal;
  descent.options.size = size / 4;
  descent.options.max_iterations = quick ? 20 : 100;
  // [D08 6.3]: from average skin, 400 iterations; small, its time extrapolated from its renders.
  FitSetting& paper = add("the paper", "descent");
  paper.is_paper = true;
  FitOptions& o = paper.options;
  o.method = FitMethod::kDescent;
  o.metric = DescentMetric::kPlain;
  o.start = StartPoint::kAverage;
  o.profiles = "multipole";
  o.forward.engine = Engine::kCascade;
  o.forward.coupling = Coupling::kGather;
  o.forward.terms = 5;
  o.forward.close_series = false;
  o.size = quick ? 16 : 32;
  o.max_iterations = quick ? 20 : 400;
  o.stop_chi2 = 0.0;
  return list;
}

std::vector<std::string> FitScenes(bool quick) {
  if (quick) return {"light", "monte_carlo_skin"};
  return {"light_freckles", "medium_vein", "dark", "step", "monte_carlo_skin"};
}

FitOptions ReferenceFit(int size) {
  FitOptions options;
  options.size = size;
  options.time_budget_s = 1e6;
  options.method = FitMethod::kCeres;
  return options;
}

}  // namespace dermap
