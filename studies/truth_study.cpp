// SPDX-License-Identifier: Apache-2.0
// Scenes, sizes and choices of what is free, and what must hold of them.
#include "studies/truth_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "studies/point_journal.h"

namespace dermap {
namespace {

constexpr int kBoundSize = 24, kLargeSize = 64, kQuickSize = 16;  // pixels along 7.5 mm
constexpr double kMostOverBound = 1.3, kNarrowest = 0.9, kWidest = 1.15, kOffCoverage = 0.03;
constexpr double kEnoughPixels = 0.5;  // a parameter of a scene counts where so many of its pixels are told

std::vector<TruthSetting> Settings(const TruthStudyOptions& options) {
  std::vector<TruthSetting> settings;
  const std::vector<std::string> scenes =
      options.quick ? std::vector<std::string>{"medium", "tattoo"}
                    : std::vector<std::string>{"light", "medium", "dark",           "vein",
                                               "step",  "tattoo", "light_freckles", "medium_vein"};
  const std::vector<int> sizes =
      options.quick ? std::vector{kQuickSize} : std::vector{kBoundSize, kLargeSize};
  for (const std::string& scene : scenes)
    for (const int size : sizes)
      for (const char* free : {"auto", "all", "paper"})
        settings.push_back({.scene = scene,
                            .free = free,
                            .size = size,
                            .draws = options.quick ? 2 : 4,
                            .seed = options.seed,
                            .bound = size != kLargeSize});
  return settings;
}

template <class Value>
double Worst(const TruthStudy& study, const Value& value) {
  double worst = 0.0;
  for (const TruthPoint& point : study.points)
    if (point.free == "auto")
      for (const TruthParameter& p : point.parameters)
        if (p.free && std::isfinite(value(p))) worst = std::max(worst, value(p));
  return worst;
}

bool Counts(const TruthParameter& p) {
  return p.claimed >= kEnoughPixels;
}

void Judge(TruthStudy& study) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  double over_all = 0.0, over_paper = 0.0;
  for (const TruthPoint& point : study.points) {
    if (point.free != "auto") continue;
    over_all = std::max(over_all, ErrorRatio(study, point, "all"));
    over_paper = std::max(over_paper, ErrorRatio(study, point, "paper"));
  }
  study.verdicts = {
      {"errors over Cramer-Rao's bound of the same free set, coupled, identifiable parameters",
       Worst(study,
             [&](const TruthParameter& p) { return p.identifiable >= kEnoughPixels ? p.over_bound : none; }),
       kMostOverBound},
      {"error bars too narrow: spread of (fit - truth) / sigma",
       Worst(study, [&](const TruthParameter& p) { return Counts(p) ? p.spread : none; }), kWidest},
      {"error bars too wide: one over that spread",
       Worst(study, [&](const TruthParameter& p) { return Counts(p) ? 1.0 / p.spread : none; }),
       1.0 / kNarrowest},
      {"68 % intervals: coverage off by",
       Worst(study,
             [&](const TruthParameter& p) { return Counts(p) ? std::abs(p.covered[k68] - 0.68) : none; }),
       kOffCoverage},
      {"95 % intervals: coverage off by",
       Worst(study,
             [&](const TruthParameter& p) { return Counts(p) ? std::abs(p.covered[k95] - 0.95) : none; }),
       kOffCoverage},
      {"errors of the chosen set over those with all free, geometric mean of table 1", over_all, 1.05},
      {"errors of the chosen set over those of table 1's five, geometric mean", over_paper, 1.05}};
  if (study.monte_carlo.bands == 0) return;
  const MonteCarloFit& judged = study.monte_carlo;
  const std::vector<Verdict> monte_carlo{
      {"under Monte Carlo's light C_m: bias", std::abs(judged.melanin_bias), 0.02},
      {"likewise, median error", judged.melanin_median, 0.03},
      {"likewise, nine of ten pixels within", judged.melanin_decile, 0.07},
      {"under Monte Carlo's light C_hd, where sigma is below half of it: bias", std::abs(judged.blood_bias),
       0.1},
      {"likewise, median error", judged.blood_median, 0.15}};
  study.verdicts.insert(study.verdicts.end(), monte_carlo.begin(), monte_carlo.end());
}

}  // namespace

double ErrorRatio(const TruthStudy& study, const TruthPoint& chosen, const std::string& other) {
  for (const TruthPoint& point : study.points) {
    if (point.scene != chosen.scene || point.size != chosen.size || point.free != other) continue;
    double logarithms = 0.0;
    for (int k = 0; k < kParameterCount; ++k)
      logarithms += std::log(chosen.parameters[k].error / point.parameters[k].error) / kParameterCount;
    return std::exp(logarithms);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

TruthStudy RunTruthStudy(const std::filesystem::path& folder, const TruthStudyOptions& options,
                         const ProgressFunction& progress) {
  TruthBench bench;
  std::vector<PlannedPoint> plan;
  for (const TruthSetting& setting : Settings(options))
    plan.push_back({fmt::format("{} {} {}", setting.scene, setting.size, setting.free),
                    setting.bound ? 8.0 : 4.0, [&, setting] { return ToJson(bench.Measure(setting)); }});
  if (!options.quick)
    plan.push_back({"monte_carlo_skin", 1.0, [] { return ToJson(MeasureMonteCarloFit()); }});
  TruthStudy study;
  study.options = options;
  const nlohmann::json settings{{"study", "truth"}, {"quick", options.quick}, {"seed", options.seed}};
  ReadRecords(RunPoints(folder, "truth", settings, plan, progress), [&](const nlohmann::json& record) {
    if (record.contains("melanin_bias"))
      study.monte_carlo = MonteCarloFitFromJson(record);
    else
      study.points.push_back(TruthPointFromJson(record));
  });
  Judge(study);
  return study;
}

}  // namespace dermap
