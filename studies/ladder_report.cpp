// SPDX-License-Identifier: Apache-2.0
// The ladder as a picture: a row a scene; rungs band by band, time saved, error beside its estimate.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "common/files/choice_record.h"
#include "fit/report_parts.h"
#include "studies/ladder_study.h"
#include "studies/study_page.h"

namespace dermap {
namespace {

constexpr double kRow = 26, kTop = 112, kName = 270, kCell = 34, kPanel = 230, kGap = 44, kMargin = 18;  // px
constexpr const char* kRungColours[] = {"#cfe8f7", "#8cc4e8", "#3f8fc7", "#0b4a7d"};
constexpr const char* kRungInk[] = {"#1f2328", "#1f2328", "#ffffff", "#ffffff"};
constexpr const char* kTimeColour = "#009e73";
constexpr const char* kErrorColour = "#d55e00";
constexpr const char* kEstimateColour = "#5b626b";

// A logarithmic panel.
struct Panel {
  double left, low, high;  // px, decades
  double At(double value) const {
    return left + std::clamp((std::log10(value) - low) / (high - low), 0.0, 1.0) * kPanel;
  }
};

std::string Text(double x, double y, const std::string& text, const char* style = "") {
  return fmt::format(R"(<text x="{:.1f}" y="{:.1f}" {}>{}</text>)", x, y, style, EscapeHtml(text));
}

std::string Ticks(const Panel& panel, double bottom) {
  std::string svg;
  for (double decade = std::ceil(panel.low); decade <= panel.high + 1e-9; decade += 1.0) {
    const double x = panel.At(std::pow(10.0, decade));
    svg += fmt::format(R"(<line x1="{0:.1f}" x2="{0:.1f}" y1="{1}" y2="{2:.1f}" stroke="#e9e7e2"/>)", x,
                       kTop - 6, bottom) +
           Text(x, kTop - 12, FormatValue(std::pow(10.0, decade)), R"(text-anchor="middle" fill="#5b626b")");
  }
  return svg;
}

std::string Cells(const LadderScene& scene, double y) {
  std::string svg;
  double x = kName;
  for (const LadderBand& band : scene.bands) {
    const auto rung = static_cast<std::size_t>(band.choice.rung);
    const std::string paths =
        band.choice.rung == Rung::kLocal ? "0"
        : band.choice.dermis_paths > 0
            ? fmt::format("{}·{}", band.choice.epidermis_paths, band.choice.dermis_paths)
            : std::to_string(band.choice.epidermis_paths);
    svg += fmt::format(R"(<g><rect x="{}" y="{:.1f}" width="{}" height="{}" fill="{}"/>)", x, y + 2,
                       kCell - 2, kRow - 4, kRungColours[rung]) +
           Text(x + 0.5 * (kCell - 2), y + 17, paths,
                fmt::format(R"(text-anchor="middle" font-size="10.5" fill="{}")", kRungInk[rung]).c_str()) +
           fmt::format("<title>{:g} nm: {}. {}</title></g>", band.wavelength_nm, RungName(band.choice.rung),
                       EscapeHtml(band.choice.why));
    x += kCell;
  }
  return svg;
}

std::string Row(const LadderScene& scene, double y, const Panel& time, const Panel& error) {
  const double middle = y + 0.5 * kRow, from = time.At(1.0), to = time.At(std::max(scene.times_faster, 1.0));
  std::string svg = Text(kMargin, y + 17, scene.name) + Cells(scene, y);
  svg += fmt::format(
      R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="9" fill="{}"><title>{} s a render</title></rect>)",
      from, middle - 4.5, std::max(to - from, 1.0), kTimeColour, FormatValue(scene.seconds));
  svg += Text(to + 6, y + 17, fmt::format("{:.1f}", scene.times_faster), R"(font-size="11")");
  svg += fmt::format(
      R"(<line x1="{0:.1f}" x2="{1:.1f}" y1="{2:.1f}" y2="{2:.1f}" stroke="#a8adb3"/>)"
      R"(<circle cx="{1:.1f}" cy="{2:.1f}" r="4.5" fill="#ffffff" stroke="{5}" stroke-width="1.8"><title>estimate {6:.2g}</title></circle>)"
      R"(<circle cx="{0:.1f}" cy="{2:.1f}" r="5" fill="{3}"><title>error {4:.2g}</title></circle>)",
      error.At(scene.error), error.At(scene.estimate), middle, kErrorColour, scene.error, kEstimateColour,
      scene.estimate);
  return svg;
}

std::string RungLegend() {
  constexpr const char* kWords[] = {"no transport", "one kernel", "two path lengths", "three or more"};
  std::string svg;
  double x = kName;
  for (std::size_t i = 0; i < 4; ++i, x += 150)
    svg += fmt::format(R"(<rect x="{}" y="38" width="13" height="13" fill="{}"/>)", x, kRungColours[i]) +
           Text(x + 19, 49, kWords[i]);
  return svg;
}

std::string Heads(const LadderScene& first, const Panel& time, const Panel& error) {
  std::string svg = Text(kName, 76, "path lengths, epidermis · dermis") +
                    Text(time.left, 76, "times faster than the full model") +
                    Text(error.left, 76, "error (dot) and the engine's estimate");
  double x = kName + 0.5 * (kCell - 2);
  for (const LadderBand& band : first.bands) {
    svg +=
        Text(x, kTop - 12, fmt::format("{:g}", band.wavelength_nm), R"(text-anchor="middle" fill="#5b626b")");
    x += kCell;
  }
  return svg;
}

std::vector<LadderScene> At(const LadderStudy& study, double tolerance) {
  std::vector<LadderScene> scenes = study.scenes;
  std::erase_if(scenes, [&](const LadderScene& scene) { return scene.tolerance != tolerance; });
  return scenes;
}

std::string Draw(const LadderStudy& study, double tolerance) {
  const std::vector<LadderScene> scenes = At(study, tolerance);
  const double bands = kCell * static_cast<double>(scenes.front().bands.size());
  double most = 10.0, least = tolerance;
  for (const LadderScene& scene : scenes) {
    most = std::max(most, scene.times_faster);
    least = std::min({least, scene.error, scene.estimate});
  }
  const Panel time{kName + bands + kGap, 0.0, std::log10(most) + 0.25};
  const Panel error{time.left + kPanel + kGap, std::floor(std::log10(std::max(least, 1e-7))),
                    std::log10(tolerance) + 0.6};
  const double bottom = kTop + kRow * static_cast<double>(scenes.size());
  const double width = error.left + kPanel + 2 * kMargin, height = bottom + 48;
  std::string svg = fmt::format(
      R"svg(<svg xmlns="http://www.w3.org/2000/svg" class="sheet" viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" height="{1:.0f}" font-family="DejaVu Sans, Segoe UI, Roboto, sans-serif" font-size="12" fill="#1f2328">
<rect width="{0:.0f}" height="{1:.0f}" fill="#ffffff"/>)svg",
      width, height);
  svg += Text(kMargin, 24,
              fmt::format("No more model than a scene needs: tolerance {:g}, {} x {} pixels", tolerance,
                          study.size, study.size),
              R"(font-size="15" font-weight="bold")");
  svg += RungLegend() + Heads(scenes.front(), time, error) + Ticks(time, bottom) + Ticks(error, bottom);
  svg += fmt::format(
      R"(<line x1="{0:.1f}" x2="{0:.1f}" y1="{1}" y2="{2:.1f}" stroke="{3}" stroke-dasharray="4 3"/>)",
      error.At(tolerance), kTop - 6, bottom, kErrorColour);
  svg += Text(error.At(tolerance), bottom + 15, "tolerance", R"(text-anchor="middle" fill="#d55e00")");
  double y = kTop;
  for (const LadderScene& scene : scenes) {
    svg += Row(scene, y, time, error);
    y += kRow;
  }
  return svg + Text(kMargin, height - 12, study.machine, R"(fill="#5b626b")") + "</svg>\n";
}

std::string Csv(const LadderStudy& study) {
  std::string text =
      "# what the engine gave each band of a scene; error: rms over the mean, to a render at a tolerance of "
      "1e-5; "
      "times_faster than the full model at the same tolerance, faster_than_reference than that render\n"
      "scene,tolerance,wavelength_nm,rung,epidermis_paths,dermis_paths,terms,margin_mm,estimate,error,"
      "scene_seconds,times_faster,faster_than_reference\n";
  for (const LadderScene& scene : study.scenes)
    for (const LadderBand& band : scene.bands)
      text += fmt::format("\"{}\",{:g},{:g},{},{},{},{},{:.3g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g}\n",
                          scene.name, scene.tolerance, band.wavelength_nm, RungName(band.choice.rung),
                          band.choice.epidermis_paths, band.choice.dermis_paths, band.choice.terms,
                          band.choice.margin_mm, band.choice.error, band.error, scene.seconds,
                          scene.times_faster, scene.faster_than_reference);
  return text;
}

std::string Page(const LadderStudy& study) {
  std::vector<std::vector<std::string>> rows{
      {"scene", "tolerance", "rungs", "time, s", "times faster", "than the reference", "error", "estimate"}};
  std::vector<double> tolerances;
  for (const LadderScene& scene : study.scenes) {
    rows.push_back({EscapeHtml(scene.name), FormatValue(scene.tolerance), RungsInWords(scene),
                    FormatValue(scene.seconds), FormatValue(scene.times_faster),
                    FormatValue(scene.faster_than_reference), FormatValue(scene.error),
                    FormatValue(scene.estimate)});
    if (std::count(tolerances.begin(), tolerances.end(), scene.tolerance) == 0)
      tolerances.push_back(scene.tolerance);
  }
  std::string charts;
  for (const double tolerance : tolerances) charts += Draw(study, tolerance);
  const std::string lead = fmt::format(
      "Scenes from uniform to wild. For each band the engine takes the lowest rung of the model that keeps "
      "the "
      "tolerance. Bars: how many times longer the full model takes at the same tolerance, that is what the "
      "wildest "
      "scene is given ({} path lengths, {} terms, {:.1f} mm beneath the tape at the default tolerance). On "
      "the right "
      "the error that is left, beside the engine's own estimate of it, against a render at a tolerance of "
      "1e-5.",
      study.full_paths, study.full_terms, study.full_margin_mm);
  return StudyPage(
      "No more model than a scene needs",
      Section("ladder", "Rung by rung", lead, charts) +
          Section("verdicts", "Verdicts", "What the study asserts, and the largest value it met.",
                  VerdictTable(study.verdicts)) +
          Section("scenes", "Every scene", "Click a heading to sort.", SortableTable(rows)));
}

nlohmann::json Json(const LadderStudy& study) {
  nlohmann::json json{{"study", "ladder"},
                      {"machine", study.machine},
                      {"seed", study.options.seed},
                      {"quick", study.options.quick},
                      {"size", study.size},
                      {"full_model",
                       {{"path_lengths", study.full_paths},
                        {"terms", study.full_terms},
                        {"margin_mm", study.full_margin_mm}}},
                      {"points", nlohmann::json::array()},
                      {"verdicts", VerdictsAsJson(study.verdicts)}};
  for (const LadderScene& scene : study.scenes) json["points"].push_back(LadderRecord(scene));
  return json;
}

}  // namespace

void WriteLadderStudy(const std::filesystem::path& folder, const LadderStudy& study) {
  FileBatch files;
  WriteFileAtomically(folder / "ladder.csv", Csv(study));
  WriteFileAtomically(folder / "ladder.svg", Draw(study, study.scenes.front().tolerance));
  WriteFileAtomically(folder / "ladder.html", Page(study));
  WriteFileAtomically(folder / "ladder.json", Json(study).dump(2) + "\n");
  files.Commit();
}

}  // namespace dermap
