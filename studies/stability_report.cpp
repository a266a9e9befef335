// SPDX-License-Identifier: Apache-2.0
// The sweeps as files: a curve a method, and a table of edges.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "studies/chart_sheet.h"
#include "studies/stability_study.h"

namespace dermap {
namespace {

constexpr double kSmallestShown = 0.2, kLargestShown = 1e3;

Chart CurveOf(const StabilityStudy& study, const std::string& sweep) {
  Chart chart;
  chart.label = chart.y_label = "error over what noise allows";
  chart.log_y = true;
  chart.width = 460;
  chart.height = 270;
  chart.reference_y = kEdgeExcess;
  chart.reference_name = "edge";
  std::map<std::string, ChartSeries> series;
  bool positive = true;
  for (const StabilityPoint& p : study.points) positive &= p.sweep != sweep || p.value > 0.0;
  for (const StabilityEdge& e : study.edges)
    if (e.sweep == sweep) chart.x_label = e.axis;
  chart.log_x = positive && sweep != "bands" && sweep != "precision";
  for (const StabilityPoint& p : study.points) {
    if (p.sweep != sweep || !p.refusal.empty()) continue;
    ChartSeries& of = series[p.method];
    of.name = p.method;
    of.colour = p.method == "fast" ? 1 : p.method == "ceres" ? 2 : 3;
    of.x.push_back(p.value);
    of.y.push_back(std::clamp(p.excess, kSmallestShown, kLargestShown));
  }
  ChartSeries silent;
  silent.name = "silently wrong";
  silent.colour = 0;
  silent.line = false;
  for (const std::size_t i : study.silently_wrong)
    if (study.points[i].sweep == sweep) {
      silent.x.push_back(study.points[i].value);
      silent.y.push_back(std::clamp(study.points[i].excess, kSmallestShown, kLargestShown));
    }
  for (const char* method : {"fast", "ceres", "descent"})
    if (series.contains(method)) chart.series.push_back(series[method]);
  if (!silent.x.empty()) chart.series.push_back(silent);
  return chart;
}

std::vector<std::string> SweepsOf(const StabilityStudy& study) {
  std::vector<std::string> names;
  for (const StabilityPoint& p : study.points)
    if (std::find(names.begin(), names.end(), p.sweep) == names.end()) names.push_back(p.sweep);
  return names;
}

std::string Csv(const StabilityStudy& study) {
  std::string csv =
      "# excess: error over what noise allows; errors, sigmas and bounds in the parameters' units; covered: "
      "share of unflagged pixels whose 95 % interval holds the truth\n"
      "sweep,method,value,excess,flagged,chi2,converged,silently_wrong,response";
  for (const ParameterInfo& info : kParameters)
    csv += fmt::format(",{0}_free,{0}_error,{0}_bound,{0}_sigma,{0}_covered", info.name);
  csv += "\n";
  for (const StabilityPoint& p : study.points) {
    csv += fmt::format("{},{},{:g},{:.4g},{:.4g},{:.4g},{:d},{:d},{}", p.sweep, p.method, p.value, p.excess,
                       p.flagged, p.chi2, p.converged, p.silently_wrong, Response(p));
    for (const ParameterStability& k : p.parameters)
      csv += fmt::format(",{:d},{:.4g},{:.4g},{:.4g},{:.4g}", k.free, k.error, k.bound, k.sigma, k.covered);
    csv += "\n";
  }
  return csv;
}

nlohmann::json Names(const StabilityStudy& study, const std::vector<std::size_t>& indices) {
  nlohmann::json names = nlohmann::json::array();
  for (const std::size_t i : indices)
    names.push_back({{"sweep", study.points[i].sweep},
                     {"method", study.points[i].method},
                     {"value", study.points[i].value}});
  return names;
}

nlohmann::json Json(const StabilityStudy& study) {
  nlohmann::json points = nlohmann::json::array(), edges = nlohmann::json::array();
  for (const StabilityPoint& p : study.points) {
    points.push_back(ToJson(p));
    points.back()["response"] = Response(p);
  }
  for (const StabilityEdge& e : study.edges) {
    nlohmann::json edge{{"sweep", e.sweep}, {"method", e.method}, {"axis", e.axis},
                        {"judge", e.judge}, {"found", e.found},   {"inside", e.inside}};
    if (e.found) edge.update({{"outside", e.outside}, {"response", e.response}});
    edges.push_back(edge);
  }
  return {{"study", "stability"},
          {"quick", study.options.quick},
          {"seed", study.options.seed},
          {"machine", study.machine},
          {"points", points},
          {"edges", edges},
          {"silently_wrong", study.silently_wrong.size()},
          {"silently_wrong_points", Names(study, study.silently_wrong)},
          {"flagged_inside_points", Names(study, study.flagged_inside)},
          {"verdicts", VerdictsAsJson(study.verdicts)}};
}

std::string EdgeTable(const StabilityStudy& study) {
  std::string rows;
  for (const StabilityEdge& e : study.edges)
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:g}</td><td>{}</td><td>{}</td></tr>\n",
                        e.axis, e.method, e.judge, e.inside,
                        e.found ? fmt::format("{:g}", e.outside) : "none met", e.found ? e.response : "");
  return "<table><thead><tr><th>swept</th><th>method</th><th>judge</th><th>still right at</th><th>wrong "
         "at</th>"
         "<th>what the program does there</th></tr></thead><tbody>\n" +
         rows + "</tbody></table>\n";
}

std::string ExceptionList(const StabilityStudy& study, const std::vector<std::size_t>& indices) {
  if (indices.empty()) return "<p>None.</p>\n";
  std::string items;
  for (const std::size_t i : indices)
    items += fmt::format("<li>{}, {}, at {:g}: error {:.2g} times what noise allows, {:.0f} % flagged</li>\n",
                         study.points[i].sweep, study.points[i].method, study.points[i].value,
                         study.points[i].excess, 100.0 * study.points[i].flagged);
  return "<ul>" + items + "</ul>\n";
}

std::string Page(const StabilityStudy& study, const std::string& sheet) {
  return "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Where each method breaks</title>\n"
         "<style>body{font:16px/1.5 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em}"
         "table{border-collapse:collapse;font-size:14px}td,th{padding:.2em .7em;border-bottom:1px solid #ddd;"
         "text-align:left}svg{max-width:100%;height:auto}</style>\n"
         "<h1>Where each method breaks, and whether it says so</h1>\n<p>One thing at a time is made worse. "
         "Each "
         "curve is the error of the maps over what noise alone allows; above 2 a method is past its edge. A "
         "point is "
         "silently wrong if, of the pixels without a flag, fewer than 90 % have the truth inside their 95 % "
         "interval in some parameter, or the median error exceeds two sigma.</p>\n" +
         sheet + "<h2>Silently wrong</h2>\n" + ExceptionList(study, study.silently_wrong) +
         "<h2>Right, yet flagged</h2>\n" + ExceptionList(study, study.flagged_inside) + "<h2>Edges</h2>\n" +
         EdgeTable(study) + fmt::format("<p>{}; seed {}.</p></html>\n", study.machine, study.options.seed);
}

}  // namespace

void WriteStabilityStudy(const std::filesystem::path& folder, const StabilityStudy& study) {
  std::vector<TitledChart> charts;
  for (const std::string& sweep : SweepsOf(study)) charts.push_back({sweep, CurveOf(study, sweep)});
  const std::string sheet = DrawChartSheet(charts, 3);
  FileBatch files;
  WriteFileAtomically(folder / "stability.csv", Csv(study));
  WriteFileAtomically(folder / "stability.json", Json(study).dump(2) + "\n");
  WriteFileAtomically(folder / "stability.svg", sheet);
  WriteFileAtomically(folder / "stability.html", Page(study, sheet));
  files.Commit();
}

}  // namespace dermap
