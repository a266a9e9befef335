// SPDX-License-Identifier: Apache-2.0
// The section on the parameter maps: value, error bar and, where it is known, the truth.
#include <algorithm>
#include <cmath>

#include "fit/report_parts.h"
#include "fit/report_sections.h"

namespace dermap {
namespace {

bool Uniform(const PlaneF& plane) {
  const auto [low, high] = std::minmax_element(plane.values().begin(), plane.values().end());
  return *low == *high;
}

// Value and truth share a scale, so that the eye may compare them.
Scale CommonScale(const PlaneF& value, const std::optional<PlaneF>& truth) {
  if (!truth) return RobustScale(value.values());
  const PlaneF both[] = {value, *truth};
  return RobustScale(std::span<const PlaneF>(both));
}

PlaneF Difference(const PlaneF& a, const PlaneF& b) {
  PlaneF result(a.width(), a.height());
  std::transform(a.values().begin(), a.values().end(), b.values().begin(), result.data(),
                 std::minus<float>());
  return result;
}

std::string TruthFigures(const ReportedMap& map, const Scale& scale, const Plane<std::uint32_t>& flags) {
  const TruthError error = CompareToTruth(map, flags);
  const PlaneF difference = Difference(*map.value, *map.truth);
  std::string html = DrawMapFigure(
      *map.truth, {"True " + map.name, "same unit", ColourMap::kViridis, scale, SpreadNote(*map.truth)});
  html += DrawMapFigure(difference, {"Error of " + map.name, "fitted - true", ColourMap::kDiverging,
                                     SymmetricScale(WithoutMasked(difference, flags).values()),
                                     "relative error: median " + Percent(error.median_relative) +
                                         ", 90th percentile " + Percent(error.percentile_90_relative)});
  return html;
}

std::string MapRow(const ReportedMap& map, const Plane<std::uint32_t>& flags) {
  const PlaneF measured = WithoutMasked(*map.value, flags);
  const Scale scale = CommonScale(measured, map.truth);
  std::string html =
      DrawMapFigure(*map.value, {map.name, map.unit, ColourMap::kViridis, scale, SpreadNote(measured)});
  if (map.free && map.sigma != nullptr) {
    const PlaneF sigma = WithoutMasked(*map.sigma, flags);
    html += DrawMapFigure(*map.sigma, {"sigma of " + map.name, "same unit", ColourMap::kMagma,
                                       RobustScale(sigma.values()), SpreadNote(sigma)});
  } else {
    html += "<p class=\"note\">Not free, so without an error bar.</p>\n";
  }
  if (map.truth) html += TruthFigures(map, scale, flags);
  return html;
}

std::string TruthTable(const ReportContext& context) {
  std::vector<std::vector<std::string>> rows{
      {"map", "median relative error", "90th percentile", "bias (median)", "median absolute error",
       "within 1 sigma<br>(68 % expected)", "within 2 sigma<br>(95 % expected)", "pixels"}};
  for (const ReportedMap& map : context.maps) {
    if (!map.truth) continue;
    const TruthError error = CompareToTruth(map, context.fit().flags);
    rows.push_back({"<b>" + EscapeHtml(map.name) + "</b>" + (map.free ? "" : " (not free)"),
                    Percent(error.median_relative), Percent(error.percentile_90_relative),
                    Percent(error.bias_relative), FormatValue(error.median_absolute, 2),
                    Percent(error.share_within_1_sigma), Percent(error.share_within_2_sigma),
                    std::to_string(error.pixels)});
  }
  if (rows.size() == 1) return {};
  return "<h3>Against the truth</h3>\n" + DrawTable(rows);
}

}  // namespace

std::string MapsSection(const ReportContext& context) {
  std::string html = TruthTable(context) + DrawErrorBarChart(context);
  std::string held, pairs;
  for (const ReportedMap& map : context.maps) {
    if (!map.free && Uniform(*map.value) && !map.truth) {
      held += "<li><b>" + EscapeHtml(map.name) + "</b> (" + EscapeHtml(map.description) + ") was held at " +
              FormatValue((*map.value)(0, 0)) + ", " + EscapeHtml(map.unit) + ".</li>\n";
      continue;
    }
    const std::string heading = "<h3>" + EscapeHtml(map.name + ": " + map.description) + "</h3>\n";
    const std::string figures = MapRow(map, context.fit().flags);
    if (map.truth) {
      html += heading + Grid(figures, 4);
    } else {
      pairs += "<div>" + heading + Grid(figures, 2) + "</div>\n";
    }
  }
  if (!pairs.empty()) html += Grid(pairs, 2);
  if (!held.empty()) html += "<h3>Not free</h3>\n<ul class=\"sentences\">" + held + "</ul>\n";
  std::string lead =
      "What the fit found in each pixel, and beside it one standard deviation of how far noise may have "
      "moved it.";
  if (context.input.truth != nullptr) {
    lead += " This sample's truth is known: it stands beside each map, averaged to the same size.";
  }
  return Section("maps", "Parameter maps", lead, html);
}

ReportContext MakeReportContext(const ReportInput& input) {
  ReportContext context{input,
                        ColourObserver(input.spectra_dir),
                        {},
                        ReportedMaps(input.fit, input.truth),
                        NamedPoints(input.fit),
                        {}};
  for (const Band& band : input.fit.bands) context.wavelengths_nm.push_back(band.wavelength_nm);
  if (input.calibration) context.calibration = ReadCalibrationRecord(*input.calibration);
  return context;
}

}  // namespace dermap
