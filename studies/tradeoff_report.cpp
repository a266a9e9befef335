// SPDX-License-Identifier: Apache-2.0
// The tradeoff study as numbers, picture and page.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "fit/report_parts.h"
#include "studies/scatter_chart.h"
#include "studies/study_page.h"
#include "studies/tradeoff_points.h"

namespace dermap {
namespace {

struct Wording {
  const char *kind, *judge, *title, *y_label;
  double scale;      // of the error
  const char* unit;  // behind a scaled error
  double level;      // 0: none
  const char* level_name;
};
constexpr Wording kWordings[] = {
    {"render", "slow reference", "Renders against the slow reference", "error of the render, %, rms", 100.0,
     " %", 0.0, ""},
    {"render", "Monte Carlo", "Renders against Monte Carlo",
     "error of the render, %, rms, Monte Carlo's noise out", 100.0, " %", 0.0, ""},
    {"fit", "truth", "Fits of simulated patches against their truth",
     "error of the maps / what noise leaves a pixel by itself", 1.0, " of the noise's", 1.0,
     "what noise leaves a pixel by itself"},
    {"fit", "reference fit", "Fits against the reference fit",
     "distance of the maps / what noise leaves a pixel by itself", 1.0, " of the noise's", 1.0,
     "what noise leaves a pixel by itself"},
    {"fit", "Monte Carlo", "Fits of the patch that Monte Carlo lit", "error of melanin, %, median", 100.0,
     " %", 0.0, ""}};

const Wording& WordsOf(const TradeoffChart& chart) {
  return *std::find_if(std::begin(kWordings), std::end(kWordings),
                       [&](const Wording& w) { return chart.kind == w.kind && chart.judge == w.judge; });
}

std::string Value(double value, const Wording& words) {
  return FormatValue(value * words.scale) + words.unit;
}

// What one sees: the default beside the paper.
std::string Sentence(const TradeoffStudy& study, const TradeoffChart& chart) {
  const Wording& words = WordsOf(chart);
  const auto paper = std::find_if(chart.dots.begin(), chart.dots.end(), [&](const TradeoffChart::Dot& dot) {
    return study.points[dot.point].is_paper;
  });
  const TradeoffChart::Dot& shipped = chart.dots[chart.shipped];
  std::string text =
      fmt::format("Default: {} s, {}.", FormatValue(shipped.seconds), Value(shipped.error, words));
  if (paper != chart.dots.end())
    text += fmt::format(" The paper's setting: {} s, {}.", FormatValue(paper->seconds),
                        Value(paper->error, words));
  return text;
}

ScatterChart Scatter(const TradeoffStudy& study, const TradeoffChart& chart) {
  const Wording& words = WordsOf(chart);
  ScatterChart out;
  out.title = chart.scene == "all" ? words.title : fmt::format("{}: {}", words.title, chart.scene);
  out.note = Sentence(study, chart);
  out.x_label =
      chart.kind == "render" ? "time of a render of eight bands, s" : "time of a fit of eight bands, s";
  out.y_label = words.y_label;
  out.level = words.level;
  out.level_name = words.level_name;
  out.front = chart.front;
  for (std::size_t i = 0; i < chart.dots.size(); ++i) {
    const TradeoffChart::Dot& dot = chart.dots[i];
    const TradeoffPoint& point = study.points[dot.point];
    auto family = std::find(out.families.begin(), out.families.end(), point.family);
    if (family == out.families.end()) family = out.families.insert(family, point.family);
    ScatterPoint& p = out.points.emplace_back();
    p.x = dot.seconds;
    p.x_bar = dot.seconds_bar;
    p.y = words.scale * dot.error;
    p.y_bar = words.scale * dot.error_bar;
    p.family = static_cast<int>(family - out.families.begin());
    p.star = point.is_default;
    p.hollow = point.is_paper;
    const bool end_of_front = !chart.front.empty() && (i == chart.front.front() || i == chart.front.back());
    if (p.star || p.hollow || end_of_front) p.label = p.star ? "default" : point.setting;
    p.title = fmt::format("{}: {} s, {}\n{}", point.setting, FormatValue(dot.seconds),
                          Value(dot.error, words), point.options);
  }
  return out;
}

std::string Sheet(const TradeoffStudy& study, const std::vector<TradeoffChart>& charts) {
  std::vector<ScatterChart> scatters;
  for (const TradeoffChart& chart : charts) scatters.push_back(Scatter(study, chart));
  return DrawScatterSheet(
      scatters, 2,
      fmt::format(
          "{}. Each dot is one setting; a star the shipped default, a ring the paper's own setting, the "
          "dashed line what nothing else beats in both. Left and low is better.",
          study.machine));
}

std::vector<TradeoffChart> Overview(const TradeoffStudy& study) {
  std::vector<TradeoffChart> charts = ChartsOfAllScenes(study.points);
  std::erase_if(charts, [](const TradeoffChart& c) { return c.judge == "reference fit"; });
  return charts;
}

std::string Csv(const TradeoffStudy& study) {
  std::string text =
      "# time against error; ratio: to the default, in pairs; errors as docs/studies.md defines them, empty: "
      "none\n"
      "kind,scene,setting,family,size_px,seconds,ratio_to_default,ratio_spread,pairs,error,error_bar,"
      "error_reference,error_monte_carlo,monte_carlo_bar,chi2,renders,default,paper,extrapolated,options\n";
  const auto known = [](double value) { return value > 0.0 ? fmt::format("{:.6g}", value) : std::string(); };
  for (const TradeoffPoint& p : study.points)
    text += fmt::format(
        "{},{},\"{}\",\"{}\",{},{:.5g},{:.5g},{:.3g},{},{:.6g},{:.3g},{},{},{},{},{},{},{},{},\"{}\"\n",
        p.kind, p.scene, p.setting, p.family, p.size, p.seconds, p.ratio, p.ratio_spread, p.pairs, p.error,
        p.error_bar, known(p.error_reference), known(p.error_monte_carlo), known(p.monte_carlo_bar),
        known(p.chi2), p.renders, int(p.is_default), int(p.is_paper), int(p.extrapolated), p.options);
  return text;
}

nlohmann::json Json(const TradeoffStudy& study) {
  nlohmann::json json{{"study", "tradeoff"},
                      {"machine", study.machine},
                      {"seed", study.options.seed},
                      {"quick", study.options.quick},
                      {"settings", {{"render_size", study.render_size}, {"fit_size", study.fit_size}}},
                      {"rounding", study.rounding},
                      {"points", nlohmann::json::array()},
                      {"front", nlohmann::json::array()},
                      {"defaults", nlohmann::json::array()},
                      {"verdicts", VerdictsAsJson(study.verdicts)},
                      {"timed_verdicts", VerdictsAsJson(study.timed)}};
  for (const TradeoffPoint& p : study.points) json["points"].push_back(ToJson(p));
  for (const TradeoffChart& chart : study.charts) {
    nlohmann::json front = nlohmann::json::array();
    for (const std::size_t i : chart.front) front.push_back(study.points[chart.dots[i].point].setting);
    const nlohmann::json where{{"kind", chart.kind}, {"judge", chart.judge}, {"scene", chart.scene}};
    json["front"].push_back(where);
    json["front"].back()["settings"] = front;
    const TradeoffChart::Dot& dot = chart.dots[chart.shipped];
    nlohmann::json& shipped = json["defaults"].emplace_back(where);
    shipped["setting"] = study.points[dot.point].setting;
    shipped["seconds"] = dot.seconds;
    shipped["error"] = dot.error;
    shipped["on_front"] = chart.shipped_on_front;
    shipped["beaten"] = !chart.shipped_beaten_by.empty();
    shipped["beaten_by"] = chart.shipped_beaten_by;
  }
  return json;
}

std::string DefaultsTable(const TradeoffStudy& study) {
  std::vector<std::vector<std::string>> rows{{"what", "judge", "scene", "time, s", "error", "on the front",
                                              "beaten by more than can be told apart"}};
  for (const TradeoffChart& chart : study.charts) {
    const TradeoffChart::Dot& dot = chart.dots[chart.shipped];
    rows.push_back({chart.kind, chart.judge, chart.scene, FormatValue(dot.seconds),
                    Value(dot.error, WordsOf(chart)), chart.shipped_on_front ? "yes" : "no",
                    chart.shipped_beaten_by.empty() ? "no" : "by " + EscapeHtml(chart.shipped_beaten_by)});
  }
  return DrawTable(rows);
}

std::string PointsTable(const TradeoffStudy& study) {
  std::vector<std::vector<std::string>> rows{{"what", "scene", "setting", "time, s", "over default", "error",
                                              "to reference fit", "to Monte Carlo", "options"}};
  const auto known = [](double value) { return value > 0.0 ? FormatValue(value) : std::string(); };
  for (const TradeoffPoint& p : study.points)
    rows.push_back({p.kind, p.scene, EscapeHtml(p.setting), FormatValue(p.seconds), FormatValue(p.ratio),
                    FormatValue(p.error), known(p.error_reference), known(p.error_monte_carlo),
                    EscapeHtml(p.options)});
  return SortableTable(rows);
}

std::string Page(const TradeoffStudy& study) {
  const std::string lead = fmt::format(
      "Each dot is one way to render or to fit: method, engine, profiles, path lengths or Gaussians, terms, "
      "size and "
      "tolerance. Left is faster, low is more right; the dashed line is what nothing else beats in both. A "
      "star is "
      "what ships, a ring the paper's own setting. Point at a dot to read it. Measured on {}; times are "
      "medians of "
      "pairs with the default.",
      study.machine);
  std::vector<Verdict> verdicts = study.verdicts;
  verdicts.insert(verdicts.end(), study.timed.begin(), study.timed.end());
  return StudyPage(
      "Speed against accuracy",
      Section("overview", "All scenes together", lead, Sheet(study, Overview(study))) +
          Section("verdicts", "Verdicts", "What the study asserts, and the largest value it met.",
                  VerdictTable(verdicts)) +
          Section("defaults", "What ships, chart by chart", "", DefaultsTable(study)) +
          Section("scenes", "Scene by scene", "", Sheet(study, study.charts)) +
          Section("points", "Every point",
                  "Click a heading to sort. Errors as fractions; of fits over what noise leaves a pixel by "
                  "itself.",
                  PointsTable(study)));
}

}  // namespace

void WriteTradeoffStudy(const std::filesystem::path& folder, const TradeoffStudy& study) {
  FileBatch files;
  WriteFileAtomically(folder / "tradeoff.csv", Csv(study));
  WriteFileAtomically(folder / "tradeoff.svg", Sheet(study, Overview(study)));
  WriteFileAtomically(folder / "tradeoff.html", Page(study));
  WriteFileAtomically(folder / "tradeoff.json", Json(study).dump(2) + "\n");
  files.Commit();
}

}  // namespace dermap
