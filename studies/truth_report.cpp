// SPDX-License-Identifier: Apache-2.0
// The truth study as files: how often intervals hold the truth, and a table of everything.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "fit/report_parts.h"
#include "studies/chart_sheet.h"
#include "studies/study_page.h"
#include "studies/truth_study.h"

namespace dermap {
namespace {

std::string_view NameOfUnknown(std::size_t k) {
  return InfoOf(static_cast<Parameter>(k)).name;
}

// What share of intervals holds the truth over what they claim, mean over the scenes, a curve a parameter.
Chart CoverageChart(const TruthStudy& study, int size) {
  Chart chart;
  chart.label = "coverage of intervals";
  chart.x_label = "share that an interval claims, %";
  chart.y_label = "share that holds the truth, %";
  chart.width = 520;
  chart.height = 400;
  ChartSeries right;
  right.name = "right";
  right.dashed = true;
  right.markers = false;
  for (const Interval& interval : kIntervals) right.x.push_back(100.0 * interval.share);
  right.y = right.x;
  chart.series.push_back(right);
  for (std::size_t k = 0; k < kUnknownCount; ++k) {
    ChartSeries series;
    series.name = NameOfUnknown(k);
    series.colour = k < kParameterCount ? static_cast<int>(k) + 1 : 0;  // ink for ink
    for (std::size_t i = 0; i < kIntervals.size(); ++i) {
      double sum = 0.0, weight = 0.0;
      for (const TruthPoint& point : study.points) {
        const TruthParameter& p = point.parameters[k];
        if (point.size != size || point.free != "auto" || !p.free || !(p.claimed > 0.0)) continue;
        sum += p.claimed * p.covered[i];
        weight += p.claimed;
      }
      if (weight > 0.0) {
        series.x.push_back(100.0 * kIntervals[i].share);
        series.y.push_back(100.0 * sum / weight);
      }
    }
    if (!series.x.empty()) chart.series.push_back(series);
  }
  return chart;
}

std::string Sheet(const TruthStudy& study) {
  std::vector<int> sizes;
  for (const TruthPoint& point : study.points)
    if (std::find(sizes.begin(), sizes.end(), point.size) == sizes.end()) sizes.push_back(point.size);
  std::vector<TitledChart> charts;
  for (const int size : sizes)
    charts.push_back(
        {fmt::format("Intervals of the default fit, {0} x {0} pixels", size), CoverageChart(study, size)});
  return DrawChartSheet(charts, 2);
}

std::string Csv(const TruthStudy& study) {
  std::string csv =
      "# error, bound: rms, parameter's unit; told: share of pixels whose bound is below half of the range's "
      "sigma; spread: rms of (fit - truth) / sigma; covered: share of 68 and 95 % intervals with the truth\n"
      "scene,size,free_set,parameter,free,error,bound,told,over_bound,claimed,spread,covered_68,covered_95\n";
  for (const TruthPoint& point : study.points)
    for (std::size_t k = 0; k < kUnknownCount; ++k) {
      const TruthParameter& p = point.parameters[k];
      csv += fmt::format("{},{},{},{},{:d},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g}\n",
                         point.scene, point.size, point.free, NameOfUnknown(k), p.free, p.error, p.bound,
                         p.identifiable, p.over_bound, p.claimed, p.spread, p.covered[k68], p.covered[k95]);
    }
  return csv;
}

std::string Cell(double value, const char* format = "{:.2f}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "";
}

// A row a scene, size and choice: what was free, and the errors' ratio to the other choices.
std::vector<std::vector<std::string>> Choices(const TruthStudy& study) {
  std::vector<std::vector<std::string>> rows{
      {"scene", "pixels", "chosen", "chi2", "errors over all free", "over table 1's five"}};
  for (const TruthPoint& point : study.points)
    if (point.free == "auto")
      rows.push_back({point.scene, std::to_string(point.size), EscapeHtml(point.chosen), Cell(point.chi2),
                      Cell(ErrorRatio(study, point, "all")), Cell(ErrorRatio(study, point, "paper"))});
  return rows;
}

std::vector<std::vector<std::string>> Details(const TruthStudy& study) {
  std::vector<std::vector<std::string>> rows{{"scene", "pixels", "free set", "parameter", "rms error",
                                              "over the bound", "spread", "68 %", "95 %",
                                              "pixels claimed, %"}};
  for (const TruthPoint& point : study.points)
    for (std::size_t k = 0; k < kUnknownCount; ++k) {
      const TruthParameter& p = point.parameters[k];
      rows.push_back({point.scene, std::to_string(point.size), point.free, std::string(NameOfUnknown(k)),
                      Cell(p.error, "{:.2g}"), p.free ? Cell(p.over_bound) : "not free", Cell(p.spread),
                      Cell(100.0 * p.covered[k68], "{:.0f}"), Cell(100.0 * p.covered[k95], "{:.0f}"),
                      Cell(100.0 * p.claimed, "{:.0f}")});
    }
  return rows;
}

nlohmann::json Json(const TruthStudy& study) {
  nlohmann::json points = nlohmann::json::array();
  for (const TruthPoint& point : study.points) {
    points.push_back(ToJson(point));
    if (point.free != "auto") continue;
    points.back()["errors_over_all"] = ErrorRatio(study, point, "all");
    points.back()["errors_over_paper"] = ErrorRatio(study, point, "paper");
  }
  nlohmann::json json{{"study", "truth"},
                      {"quick", study.options.quick},
                      {"seed", study.options.seed},
                      {"points", points},
                      {"verdicts", VerdictsAsJson(study.verdicts)}};
  if (study.monte_carlo.bands > 0) json["monte_carlo"] = ToJson(study.monte_carlo);
  return json;
}

}  // namespace

void WriteTruthStudy(const std::filesystem::path& folder, const TruthStudy& study) {
  const std::string sheet = Sheet(study);
  const std::string page = StudyPage(
      "The fit against the truth",
      Section("verdicts", "What was asked", "", VerdictTable(study.verdicts)) +
          Section("intervals", "Whether error bars are right",
                  "Of the pixels that the fit claims to know, all scenes together.", sheet) +
          Section("choices", "Whether the choice of what is free pays",
                  "Errors of the chosen set over those of another, geometric mean over table 1's parameters.",
                  DrawTable(Choices(study))) +
          Section("all", "Everything", "Click a heading to sort.", SortableTable(Details(study))));
  FileBatch files;
  WriteFileAtomically(folder / "truth.csv", Csv(study));
  WriteFileAtomically(folder / "truth.json", Json(study).dump(2) + "\n");
  WriteFileAtomically(folder / "truth.svg", sheet);
  WriteFileAtomically(folder / "truth.html", page);
  files.Commit();
}

}  // namespace dermap
