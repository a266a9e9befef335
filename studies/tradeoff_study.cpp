// SPDX-License-Identifier: Apache-2.0
// Every setting on every scene, and what must hold of them.
#include "studies/tradeoff_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/transport/forward_model.h"
#include "studies/point_journal.h"
#include "studies/tradeoff_points.h"

namespace dermap {
namespace {

constexpr int kRenderSize = 256, kFitSize = 64, kQuickRenderSize = 64, kQuickFitSize = 32;
constexpr double kFitCost = 8.0;  // a fit by default over a render by default
// What grids and stencils leave of a render (docs/heterogeneous_skin.md), whatever tolerance from 1e-4 up is
// asked for.
constexpr double kGrids = 3e-4;
constexpr double kSecondsAPoint = 2.0;

double Tolerance(const RenderSetting& setting) {
  const bool automatic = setting.forward.engine == Engine::kLowRank &&
                         setting.forward.coupling == Coupling::kReciprocal && setting.profiles == "exact" &&
                         setting.forward.path_lengths == kAutomaticPaths &&
                         setting.forward.terms == kAutomaticTerms;
  return automatic ? setting.forward.tolerance : 0.0;
}

// Largest of value(point) over the points that it is positive of.
template <class Value>
double Worst(const std::vector<TradeoffPoint>& points, const Value& value) {
  double worst = 0.0;
  for (const TradeoffPoint& p : points) worst = std::max(worst, value(p));
  return worst;
}

// The default's error over the paper's, largest over the scenes.
double OverPaper(const std::vector<TradeoffPoint>& points, const char* kind, double TradeoffPoint::*error) {
  return Worst(points, [&](const TradeoffPoint& shipped) {
    if (!shipped.is_default || shipped.kind != kind) return 0.0;
    return Worst(points, [&](const TradeoffPoint& paper) {
      return paper.is_paper && paper.kind == kind && paper.scene == shipped.scene && paper.*error > 0.0
                 ? shipped.*error / paper.*error
                 : 0.0;
    });
  });
}

void Judge(TradeoffStudy& study, const std::vector<RenderSetting>& renders) {
  const auto& points = study.points;
  const auto shipped = [](const TradeoffPoint& p, const char* kind) {
    return p.is_default && p.kind == kind;
  };
  const double over_tolerance = Worst(points, [&](const TradeoffPoint& p) {
    const auto setting = std::find_if(renders.begin(), renders.end(), [&](const RenderSetting& s) {
      return p.kind == "render" && s.name == p.setting && s.size == study.render_size;
    });
    const double tolerance = setting == renders.end() ? 0.0 : Tolerance(*setting);
    return tolerance > 0.0 ? p.error / std::max(tolerance, kGrids) : 0.0;
  });
  study.verdicts = {
      {"at full size the default engine keeps its tolerance (3e-4 at the least, its grids): error over "
       "tolerance",
       over_tolerance, 1.0},
      {"the default render is closer to Monte Carlo than the paper's setting: its error over the paper's",
       OverPaper(points, "render", &TradeoffPoint::error_monte_carlo), 0.5},
      {"the default render is within 2 % of Monte Carlo, its noise taken out",
       Worst(points, [&](const auto& p) { return shipped(p, "render") ? p.error_monte_carlo : 0.0; }), 0.02},
      {"the default fit is closer to the truth than the paper's: its error over the paper's",
       OverPaper(points, "fit", &TradeoffPoint::error), 0.5},
      {"the default fit is as near to the reference fit as noise lets a pixel by itself know",
       Worst(points, [&](const auto& p) { return shipped(p, "fit") ? p.error_reference : 0.0; }), 1.0},
      {"the default fit finds melanin under Monte Carlo's light: median relative error of C_m",
       Worst(points, [&](const auto& p) { return shipped(p, "fit") ? p.error_monte_carlo : 0.0; }), 0.1},
      {"rounding to single precision is below a hundredth of the default's tolerance: share of it",
       study.rounding / ForwardOptions{}.tolerance, 0.01}};
  study.timed = {{"charts in which another setting is faster and more right than the shipped default",
                  static_cast<double>(
                      std::count_if(study.charts.begin(), study.charts.end(),
                                    [](const TradeoffChart& c) { return !c.shipped_beaten_by.empty(); })),
                  0.0}};
}

}  // namespace

TradeoffStudy RunTradeoffStudy(const std::filesystem::path& folder, const TradeoffOptions& options,
                               const ProgressFunction& progress) {
  TradeoffStudy study;
  study.options = options;
  study.render_size = options.quick ? kQuickRenderSize : kRenderSize;
  study.fit_size = options.quick ? kQuickFitSize : kFitSize;
  study.machine = MachineName();
  const double budget_s = options.quick ? 0.0 : kSecondsAPoint;
  TradeoffMeter renders(study.render_size, options.seed, budget_s),
      fits(study.fit_size, options.seed, budget_s);
  const auto render_settings = RenderSettings(study.render_size, options.quick);
  const auto fit_settings = FitSettings(study.fit_size, options.quick);

  std::vector<PlannedPoint> plan;
  for (const std::string& scene : RenderScenes(options.quick))
    for (const RenderSetting& setting : render_settings)
      plan.push_back({fmt::format("render {}: {}", scene, setting.name), 1.0 + setting.cost,
                      [&renders, &setting, scene] { return ToJson(renders.Render(setting, scene)); }});
  for (const std::string& scene : FitScenes(options.quick))
    for (const FitSetting& setting : fit_settings)
      plan.push_back({fmt::format("fit {}: {}", scene, setting.name), kFitCost * (1.0 + setting.cost),
                      [&fits, &setting, scene] { return ToJson(fits.Fit(setting, scene)); }});
  plan.push_back(
      {"rounding", 1.0, [&] {
         return nlohmann::json{{"rounding", renders.Rounding(RenderScenes(options.quick).front())}};
       }});
  const nlohmann::json settings{{"study", "tradeoff"},        {"quick", options.quick},
                                {"seed", options.seed},       {"render_size", study.render_size},
                                {"fit_size", study.fit_size}, {"machine", study.machine}};
  const PointRun run = RunPoints(folder, "tradeoff", settings, plan, progress);
  study.resumed = run.resumed;
  ReadRecords(run, [&](const nlohmann::json& record) {
    if (record.contains("rounding"))
      study.rounding = record["rounding"];
    else
      study.points.push_back(TradeoffPointFromJson(record));
  });
  study.charts = ChartsOf(study.points);
  Judge(study, render_settings);
  return study;
}

}  // namespace dermap
