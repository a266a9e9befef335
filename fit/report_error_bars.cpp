// SPDX-License-Identifier: Apache-2.0
// The chart that says whether error bars are right: how often the truth lies within so many sigma.
#include <algorithm>
#include <cmath>
#include <vector>

#include "fit/report_chart.h"
#include "fit/report_sections.h"

namespace dermap {
namespace {

constexpr double kStep = 0.125, kWidest = 3.0;  // sigma

// Errors over sigma, without sign, sorted; of pixels that were fitted.
std::vector<float> ScaledErrors(const ReportedMap& map, const Plane<std::uint32_t>& flags) {
  std::vector<float> scaled;
  for (std::size_t i = 0; i < map.value->size(); ++i) {
    const float sigma = map.sigma->data()[i], error = map.value->data()[i] - map.truth->data()[i];
    const bool masked = !flags.empty() && (flags.data()[i] & kFlagSaturated) != 0;
    if (!masked && sigma > 0.0f && std::isfinite(error)) scaled.push_back(std::abs(error) / sigma);
  }
  std::sort(scaled.begin(), scaled.end());
  return scaled;
}

}  // namespace

std::string DrawErrorBarChart(const ReportContext& context) {
  Chart chart;
  chart.label = "Share of the pixels whose truth lies within so many sigma";
  chart.x_label = "sigma";
  chart.y_label = "share of the pixels, %";
  chart.y_from = 0.0;
  ChartSeries expected;
  expected.name = "where error bars are right";
  expected.dashed = true;
  expected.markers = false;
  for (double z = 0.0; z <= kWidest; z += kStep) {
    expected.x.push_back(z);
    expected.y.push_back(100.0 * std::erf(z / std::sqrt(2.0)));
  }
  chart.series.push_back(std::move(expected));
  for (const ReportedMap& map : context.maps) {
    if (!map.truth || !map.free || map.sigma == nullptr) continue;
    const std::vector<float> scaled = ScaledErrors(map, context.fit().flags);
    if (scaled.empty()) continue;
    ChartSeries series;
    series.name = map.name;
    series.colour = static_cast<int>(chart.series.size());
    series.markers = false;
    for (double z = 0.0; z <= kWidest; z += kStep) {
      const auto within = std::upper_bound(scaled.begin(), scaled.end(), static_cast<float>(z));
      series.x.push_back(z);
      series.y.push_back(100.0 * static_cast<double>(within - scaled.begin()) /
                         static_cast<double>(scaled.size()));
    }
    chart.series.push_back(std::move(series));
  }
  if (chart.series.size() == 1) return {};
  return "<h3>Are the error bars right?</h3>\n<p class=\"note\">Lines on the dashed one: sigma is what it "
         "says. "
         "Above it: sigma is too wide; below: too narrow.</p>\n" +
         DrawChart(chart);
}

}  // namespace dermap
