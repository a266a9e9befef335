// SPDX-License-Identifier: Apache-2.0
// Points sorted into charts, with their fronts.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "studies/noise_bound.h"
#include "studies/pareto.h"
#include "studies/tradeoff_study.h"

namespace dermap {
namespace {

struct Judge {
  const char *kind, *name;
  double TradeoffPoint::*error;
  double TradeoffPoint::*bar;
};
constexpr Judge kJudges[] = {
    {"render", "slow reference", &TradeoffPoint::error, &TradeoffPoint::error_bar},
    {"render", "Monte Carlo", &TradeoffPoint::error_monte_carlo, &TradeoffPoint::monte_carlo_bar},
    {"fit", "truth", &TradeoffPoint::error, &TradeoffPoint::error_bar},
    {"fit", "reference fit", &TradeoffPoint::error_reference, &TradeoffPoint::reference_bar},
    {"fit", "Monte Carlo", &TradeoffPoint::error_monte_carlo, &TradeoffPoint::monte_carlo_bar}};

// What a scene's yardstick took, median of its pairs: a point's time is its ratio times this, so that what
// slowed the machine down meanwhile cancels.
std::map<std::pair<std::string, std::string>, double> YardstickSeconds(
    const std::vector<TradeoffPoint>& points) {
  std::map<std::pair<std::string, std::string>, std::vector<double>> seconds;
  for (const TradeoffPoint& p : points)
    if (p.ratio > 0.0) seconds[{p.kind, p.scene}].push_back(p.seconds / p.ratio);
  std::map<std::pair<std::string, std::string>, double> medians;
  for (auto& [key, values] : seconds) medians[key] = MedianOrNaN(std::move(values));
  return medians;
}

std::vector<std::string> ScenesOf(const std::vector<TradeoffPoint>& points, const std::string& kind) {
  std::vector<std::string> scenes;
  for (const TradeoffPoint& p : points)
    if (p.kind == kind && std::find(scenes.begin(), scenes.end(), p.scene) == scenes.end())
      scenes.push_back(p.scene);
  return scenes;
}

void DrawFront(const std::vector<TradeoffPoint>& points, TradeoffChart& chart) {
  std::vector<TimedError> timed;
  for (const TradeoffChart::Dot& dot : chart.dots) timed.push_back({dot.seconds, dot.error, dot.error_bar});
  chart.front = ParetoFront(timed);
  for (std::size_t i = 0; i < chart.dots.size(); ++i)
    if (points[chart.dots[i].point].is_default) chart.shipped = i;
  chart.shipped_on_front = std::count(chart.front.begin(), chart.front.end(), chart.shipped) > 0;
  for (std::size_t i = 0; i < timed.size(); ++i)
    if (IsDominated({timed[chart.shipped], timed[i]}, 0))
      chart.shipped_beaten_by = points[chart.dots[i].point].setting;
}

// Geometric means of the dots of one setting; bars: one standard deviation of the logarithms.
TradeoffChart::Dot MeanOf(const std::vector<TradeoffChart::Dot>& dots) {
  const auto count = static_cast<double>(dots.size());
  const auto mean = [&](double TradeoffChart::Dot::*value) {
    double sum = 0.0, square = 0.0;
    for (const auto& dot : dots) sum += std::log(dot.*value) / count;
    for (const auto& dot : dots) square += std::pow(std::log(dot.*value) - sum, 2) / count;
    return std::pair(std::exp(sum), std::exp(sum) * std::expm1(std::sqrt(square)));
  };
  const auto [seconds, seconds_spread] = mean(&TradeoffChart::Dot::seconds);
  const auto [error, error_spread] = mean(&TradeoffChart::Dot::error);
  return {dots.front().point, seconds, seconds_spread, error, error_spread};
}

}  // namespace

std::vector<TradeoffChart> ChartsOf(const std::vector<TradeoffPoint>& points) {
  std::vector<TradeoffChart> charts;
  const auto yardsticks = YardstickSeconds(points);
  for (const Judge& judge : kJudges)
    for (const std::string& scene : ScenesOf(points, judge.kind)) {
      TradeoffChart chart{.kind = judge.kind, .judge = judge.name, .scene = scene, .dots = {}, .front = {}};
      for (std::size_t i = 0; i < points.size(); ++i) {
        const TradeoffPoint& p = points[i];
        if (p.kind != judge.kind || p.scene != scene || !(p.*judge.error > 0.0)) continue;
        const double seconds = p.ratio * yardsticks.at({p.kind, p.scene});
        chart.dots.push_back({i, seconds, seconds * p.ratio_spread, p.*judge.error, p.*judge.bar});
      }
      if (chart.dots.empty()) continue;
      DrawFront(points, chart);
      charts.push_back(std::move(chart));
    }
  return charts;
}

std::vector<TradeoffChart> ChartsOfAllScenes(const std::vector<TradeoffPoint>& points) {
  std::vector<TradeoffChart> merged;
  const std::vector<TradeoffChart> charts = ChartsOf(points);
  for (const Judge& judge : kJudges) {
    std::map<std::string, std::vector<TradeoffChart::Dot>> by_setting;
    std::vector<std::string> order;
    std::size_t scenes = 0;
    for (const TradeoffChart& chart : charts) {
      if (chart.kind != judge.kind || chart.judge != judge.name) continue;
      // Cells of 0.23 mm are no scene to put together with pixels; it has charts of its own.
      const bool cells = chart.kind == "fit" && chart.scene == "monte_carlo_skin";
      if (cells && chart.judge != "Monte Carlo") continue;
      ++scenes;
      for (const TradeoffChart::Dot& dot : chart.dots) {
        auto& dots = by_setting[points[dot.point].setting];
        if (dots.empty()) order.push_back(points[dot.point].setting);
        dots.push_back(dot);
      }
    }
    if (scenes == 0) continue;
    TradeoffChart chart{.kind = judge.kind, .judge = judge.name, .scene = "all", .dots = {}, .front = {}};
    for (const std::string& setting : order)
      if (by_setting[setting].size() == scenes)
        chart.dots.push_back(scenes == 1 ? by_setting[setting].front() : MeanOf(by_setting[setting]));
    DrawFront(points, chart);
    merged.push_back(std::move(chart));
  }
  return merged;
}

}  // namespace dermap
