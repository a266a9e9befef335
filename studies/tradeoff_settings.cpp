// SPDX-License-Identifier: Apache-2.0
// Which settings and scenes the tradeoff study goes through.
#include <fmt/format.h>

#include "studies/tradeoff_points.h"

namespace dermap {
namespace {

constexpr const char* kBothEnds = "lowrank, both ends of a path: the default engine";
constexpr const char* kExitAlone = "lowrank, exit alone";
constexpr const char* kPyramid = "pyramid";
constexpr const char* kCascade = "cascade: the paper's engine";
constexpr const char* kPublished = "published optics (multipole), any engine";

constexpr const char* kFast = "fast: the default method";
constexpr const char* kFastOther = "fast, other engines and couplings";
constexpr const char* kFastPublished = "fast, published optics (multipole)";
constexpr const char* kDescent = "descent: the paper's method";
constexpr const char* kCeres = "ceres: the reference";

using Numbers = std::vector<double>;

// Costs are rough, in renders by the default.
class RenderList {
 public:
  RenderSetting& Add(const char* family, int size, const std::string& what, double cost) {
    RenderSetting& s = list_.emplace_back();
    s.name = fmt::format("{} px, {}", size, what);
    s.family = family;
    s.size = size;
    s.cost = cost;
    return s;
  }
  RenderSetting& AddGaussians(Engine engine, int size, int step) {
    const bool cascade = engine == Engine::kCascade;
    auto& s = Add(cascade ? kCascade : kPyramid, size,
                  fmt::format("{}, {} Gaussians", EngineName(engine), 18 / step), cascade ? 20.0 : 5.0);
    s.forward.engine = engine;
    s.forward.gaussian_step = step;
    return s;
  }
  std::vector<RenderSetting> Take() { return std::move(list_); }

 private:
  std::vector<RenderSetting> list_;
};

void AddLowRank(RenderList& list, int size, bool quick) {
  for (const int divisor : quick ? std::vector<int>{1, 2} : std::vector<int>{1, 2, 4})
    for (const double tolerance :
         quick ? Numbers{1e-2, 1e-3, 1e-4} : Numbers{1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4}) {
      auto& s = list.Add(kBothEnds, size / divisor, fmt::format("tolerance {:g}", tolerance), 1.0);
      s.forward.tolerance = tolerance;
      s.is_default = divisor == 1 && tolerance == ForwardOptions{}.tolerance;
    }
  for (const int paths : quick ? std::vector<int>{1, 4} : std::vector<int>{1, 2, 3, 4, 6, 8})
    list.Add(kBothEnds, size, fmt::format("{} path length{}", paths, paths > 1 ? "s" : ""), 1.0)
        .forward.path_lengths = paths;
  for (const int terms : quick ? std::vector<int>{1} : std::vector<int>{0, 1, 2, 5})
    list.Add(kBothEnds, size, fmt::format("{} term{}", terms, terms == 1 ? "" : "s"), 1.0).forward.terms =
        terms;
  for (const int divisor : quick ? std::vector<int>{1} : std::vector<int>{1, 4})
    for (const double tolerance : quick ? Numbers{1e-3} : Numbers{1e-2, 1e-3, 1e-4}) {
      auto& s =
          list.Add(kExitAlone, size / divisor, fmt::format("exit alone, tolerance {:g}", tolerance), 1.0);
      s.forward.coupling = Coupling::kGather;
      s.forward.tolerance = tolerance;
    }
}

void AddPublished(RenderList& list, int size, bool quick) {
  for (const char* profiles : {"multipole", "multipole-symmetric"}) {
    if (quick && std::string(profiles) != "multipole") continue;
    for (const Engine engine : {Engine::kLowRank, Engine::kPyramid}) {
      if (quick && engine != Engine::kLowRank) continue;
      auto& s = list.Add(kPublished, size, fmt::format("{}, {}", profiles, EngineName(engine)),
                         engine == Engine::kPyramid ? 5.0 : 1.0);
      s.profiles = profiles;
      s.forward.engine = engine;
    }
  }
  auto& paper = list.Add(kPublished, size, "the paper", 20.0);  // [D08 4]: 18 blurs, 5 terms, exit alone
  paper.name = "the paper";
  paper.profiles = "multipole";
  paper.forward.engine = Engine::kCascade;
  paper.forward.coupling = Coupling::kGather;
  paper.forward.terms = 5;
  paper.forward.close_series = false;
  paper.is_paper = true;
}

class FitList {
 public:
  FitSetting& Add(const char* family, int size, const std::string& what, double cost) {
    FitSetting& s = list_.emplace_back();
    s.name = what.empty() ? fmt::format("{} px", size) : fmt::format("{} px, {}", size, what);
    s.family = family;
    s.options.size = size;
    s.options.time_budget_s = 1e6;
    s.cost = cost;
    return s;
  }
  FitSetting& AddEngine(const char* family, const std::string& profiles, int size, Engine engine,
                        double cost) {
    auto& s = Add(family, size, fmt::format("{}, {}", profiles, EngineName(engine)), cost);
    s.options.profiles = profiles;
    s.options.forward.engine = engine;
    return s;
  }
  std::vector<FitSetting> Take() { return std::move(list_); }

 private:
  std::vector<FitSetting> list_;
};

void AddFast(FitList& list, int size, bool quick) {
  for (const int divisor : quick ? std::vector<int>{1, 2} : std::vector<int>{1, 2, 4})
    for (const double tolerance : quick ? Numbers{0.0, 1e-2} : Numbers{0.0, 1e-2, 3e-3, 3e-4}) {
      auto& s = list.Add(kFast, size / divisor,
                         tolerance > 0.0 ? fmt::format("tolerance {:g}", tolerance) : "", 1.0);
      s.options.tolerance = tolerance;  // 0: a tenth of the noise
      s.is_default = divisor == 1 && tolerance == 0.0;
    }
  if (!quick) {
    for (const int paths : {4, 6})
      list.Add(kFast, size, fmt::format("{} path lengths", paths), 1.0).options.forward.path_lengths = paths;
    list.Add(kFast, size, "1 term", 1.0).options.forward.terms = 1;
    list.Add(kFastOther, size, "exit alone", 1.0).options.forward.coupling = Coupling::kGather;
    list.AddEngine(kFastOther, "exact", size / 4, Engine::kPyramid, 1.0);
    auto& few = list.AddEngine(kFastOther, "exact", size, Engine::kPyramid, 6.0);
    few.name += ", 9 Gaussians";
    few.options.forward.gaussian_step = 2;
    list.AddEngine(kFastOther, "exact", size, Engine::kCascade, 20.0);
    list.AddEngine(kFastPublished, "multipole", size, Engine::kPyramid, 6.0);
    list.AddEngine(kFastPublished, "multipole-symmetric", size, Engine::kLowRank, 2.0);
  }
  list.AddEngine(kFastOther, "exact", size, Engine::kPyramid, 6.0);
  list.AddEngine(kFastPublished, "multipole", size, Engine::kLowRank, 2.0);
}

void AddDescent(FitList& list, int size, bool quick) {
  for (const int iterations : quick ? std::vector<int>{20} : std::vector<int>{25, 100}) {
    auto& s = list.Add(kDescent, size / 4, fmt::format("{} iterations from the local inversion", iterations),
                       0.1 * iterations);
    s.options.method = FitMethod::kDescent;
    s.options.start = StartPoint::kLocal;
    s.options.max_iterations = iterations;
  }
  // [D08 6.3]: from average skin, 400 iterations, plain gradient; small, its time extrapolated from its
  // renders.
  FitSetting& paper = list.Add(kDescent, size, "the paper", 60.0);
  paper.name = "the paper";
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
}

}  // namespace

std::vector<RenderSetting> RenderSettings(int size, bool quick) {
  RenderList list;
  AddLowRank(list, size, quick);
  for (const Engine engine : {Engine::kPyramid, Engine::kCascade})
    for (const int step : quick ? std::vector<int>{1, 6} : std::vector<int>{1, 2, 3, 6})
      list.AddGaussians(engine, size, step);
  if (!quick) {
    list.AddGaussians(Engine::kPyramid, size / 4, 1);
    list.AddGaussians(Engine::kCascade, size / 4, 1).cost = 2.0;
    auto& terms = list.AddGaussians(Engine::kPyramid, size, 1);
    terms.name += ", 2 terms";
    terms.forward.terms = 2;
  }
  AddPublished(list, size, quick);
  return list.Take();
}

std::vector<std::string> RenderScenes(bool quick) {
  if (quick) return {"light", "monte_carlo_skin"};
  return {"light_freckles", "medium_vein", "dark", "step", "tattoo", "monte_carlo_skin"};
}

std::vector<FitSetting> FitSettings(int size, bool quick) {
  FitList list;
  AddFast(list, size, quick);
  AddDescent(list, size, quick);
  for (const int divisor : quick ? std::vector<int>{2} : std::vector<int>{1, 2, 4}) {
    auto& s = list.Add(kCeres, size / divisor, "ceres", 60.0 / (divisor * divisor));
    s.options.method = FitMethod::kCeres;
  }
  return list.Take();
}

std::vector<std::string> FitScenes(bool quick) {
  if (quick) return {"light", "monte_carlo_skin"};
  return {"light_freckles", "dark", "monte_carlo_skin"};
}

FitOptions ReferenceFit(int size) {
  FitOptions options;
  options.size = size;
  options.time_budget_s = 1e6;
  options.method = FitMethod::kCeres;
  return options;
}

}  // namespace dermap
