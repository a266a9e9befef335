// SPDX-License-Identifier: Apache-2.0
// Sections in words and figures: headline, convergence, flags, decisions, how to read the page.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "fit/report_chart.h"
#include "fit/report_parts.h"
#include "fit/report_sections.h"

namespace dermap {
namespace {

struct FlagInfo {
  FitFlag flag;
  const char* name() const { return kFitFlagNames[std::countr_zero(static_cast<std::uint32_t>(flag))]; }
  const char* meaning;
  Rgb8 colour;  // Okabe and Ito's, which colour-blind people tell apart
};

// The first that a pixel has gives its colour in the map.
constexpr FlagInfo kFlags[] = {
    {kFlagSaturated,
     "saturated, dead or outside the valid area; its parameters are its neighbours' mean",
     {230, 159, 0}},
    {kFlagOutsideValidity, "a reflectance that the model cannot produce", {213, 94, 0}},
    {kFlagNotConverged, "the pixel's own residual is far above its noise", {204, 121, 167}},
    {kFlagUnexplained,
     "the data contradict the model by far more than their noise; how far the maps are off is a guess",
     {240, 228, 66}},
    {kFlagAtBound, "a free parameter ended at the lower or upper end of its range", {0, 114, 178}},
    {kFlagNotIdentifiable,
     "the error bar of a free parameter is more than half as wide as its range alone says: the data hardly "
     "tell",
     {86, 180, 233}},
};
constexpr Rgb8 kNoFlag{226, 230, 226};

std::string Tile(const std::string& key, const std::string& value, const std::string& detail = {},
                 bool is_text = false) {
  std::string html = "<div class=\"tile\"><span class=\"k\">" + EscapeHtml(key) + "</span><span class=\"v" +
                     (is_text ? " text" : "") + "\">" + EscapeHtml(value) + "</span>";
  if (!detail.empty()) html += "<span class=\"d\">" + EscapeHtml(detail) + "</span>";
  return html + "</div>\n";
}

std::string FreeParameters(const FitResult& fit) {
  std::string names;
  for (const Parameter p : fit.free_parameters) {
    names += (names.empty() ? "" : ", ") + std::string(InfoOf(p).name);
  }
  return names.empty() ? "none" : names;
}

std::string Verdict(const FitResult& fit) {
  std::string text = "The prediction differs from the measurement by " + Percent(fit.rms_residual) +
                     " of the light that falls on the skin (rms over all bands and pixels)";
  if (fit.chi2 < 0.5) {
    text += "; that is less than the stated noise, which is therefore probably too large.";
  } else if (fit.chi2 < 1.5) {
    text += "; that is what the noise of the measurement explains.";
  } else {
    text +=
        ", " + FormatValue(std::sqrt(fit.chi2), 2) +
        " times what the noise explains: something in the skin or in the measurement is not in the model.";
  }
  return text;
}

double SharePixels(const Plane<std::uint32_t>& flags, std::uint32_t mask) {
  const auto count = std::count_if(flags.values().begin(), flags.values().end(),
                                   [&](std::uint32_t value) { return (value & mask) != 0; });
  return static_cast<double>(count) / static_cast<double>(flags.size());
}

std::string Hex(const Rgb8& c) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", c[0], c[1], c[2]);
  return text;
}

template <class Choose>
Plane<Rgb8> FlagPicture(const Plane<std::uint32_t>& flags, Choose colour_of) {
  Plane<Rgb8> picture(flags.width(), flags.height());
  std::transform(flags.values().begin(), flags.values().end(), picture.data(), colour_of);
  return picture;
}

Chart HistoryChart(const FitResult& fit, double FitIteration::*value) {
  Chart chart;
  chart.x_label = "renders of the whole patch";
  chart.log_y = true;
  chart.height = 300;
  chart.width = 560;
  ChartSeries series;
  series.colour = 1;
  for (const FitIteration& step : fit.history) {
    series.x.push_back(step.renders);
    series.y.push_back(step.*value);
  }
  series.markers = fit.history.size() <= 60;
  chart.series.push_back(std::move(series));
  return chart;
}

}  // namespace

std::string HeadlineSection(const ReportContext& context) {
  const FitResult& fit = context.fit();
  std::string html = "<p class=\"kicker\">Skin parameters from a reflectance stack</p>\n<h1>" +
                     EscapeHtml(context.input.name) + "</h1>\n<p class=\"verdict\">";
  html += fit.converged && !fit.Explained() ? "<span class=\"badge warn\">data not explained</span>"
          : fit.converged                   ? "<span class=\"badge good\">converged</span>"
          : fit.finished
              ? "<span class=\"badge warn\">not converged</span>"
              : "<span class=\"badge warn\">INTERRUPTED</span><strong role=\"alert\">This fit was "
                "stopped before it was done. Do not read the maps as results: go on with dermap fit "
                "--resume. </strong>";
  html += EscapeHtml(Verdict(fit)) + "</p>\n<div class=\"tiles\">\n";
  html += Tile("rms residual", Percent(fit.rms_residual), "of reflectance 1");
  html += Tile("chi2 per degree of freedom", FormatValue(fit.chi2), "1: as large as the noise");
  html +=
      Tile("time", FormatValue(fit.seconds) + " s", std::to_string(fit.renders) + " renders of the patch");
  const double pixel_mm = fit.conditions.pixel_size_mm;
  html += Tile("size", std::to_string(fit.maps.width()) + " x " + std::to_string(fit.maps.height()),
               pixel_mm > 0.0 ? "pixels of " + FormatValue(pixel_mm) + " mm" : "pixels");
  html += Tile("bands", std::to_string(fit.bands.size()),
               FormatValue(context.wavelengths_nm.front(), 4) + " to " +
                   FormatValue(context.wavelengths_nm.back(), 4) + " nm");
  html += Tile("method", fit.method, "profiles " + fit.profiles + ", engine " + fit.engine, true);
  html += Tile("free parameters", FreeParameters(fit),
               std::to_string(fit.free_parameters.size()) + " in each pixel", true);
  if (!fit.flags.empty())
    html += Tile("flagged pixels", Percent(SharePixels(fit.flags, ~0u)), "see the flags below");
  return html + "</div>\n";
}

std::string ConvergenceSection(const ReportContext& context) {
  const FitResult& fit = context.fit();
  Chart rms = HistoryChart(fit, &FitIteration::rms_residual);
  rms.label = "rms residual against renders";
  rms.y_label = "rms residual, reflectance";
  Chart chi2 = HistoryChart(fit, &FitIteration::chi2);
  chi2.label = "chi2 per degree of freedom against renders";
  chi2.y_label = "chi2 per degree of freedom";
  chi2.reference_y = 1.0;
  chi2.reference_name = "noise";
  std::string body = Grid("<div>" + DrawChart(rms) + "</div>\n<div>" + DrawChart(chi2) + "</div>\n", 2);
  if (!fit.history.empty()) {
    const FitIteration& last = fit.history.back();
    body += "<p class=\"note\">" + std::to_string(last.iteration) + " iterations, " +
            std::to_string(last.renders) + " renders, " + FormatValue(last.seconds) + " s.</p>\n";
  }
  return Section(
      "convergence", "Convergence",
      "How the difference between prediction and measurement fell with the work done. The "
      "vertical axes are logarithmic. Steps upwards: a method that goes from coarse to fine moved on "
      "to a finer size.",
      body);
}

std::string FlagsSection(const ReportContext& context) {
  const auto& flags = context.fit().flags;
  const char* lead =
      "Pixels whose values need care. Where a pixel has several flags, the map shows the first of the list.";
  if (flags.empty())
    return Section("flags", "Flags", lead, "<p class=\"note\">The fit recorded no flags.</p>\n");
  const auto composite = FlagPicture(flags, [](std::uint32_t value) {
    for (const FlagInfo& info : kFlags) {
      if ((value & info.flag) != 0) return info.colour;
    }
    return kNoFlag;
  });
  std::vector<std::vector<std::string>> rows{{"", "flag", "pixels", "meaning"}};
  for (const FlagInfo& info : kFlags) {
    const auto only = FlagPicture(
        flags, [&](std::uint32_t value) { return (value & info.flag) != 0 ? info.colour : kNoFlag; });
    rows.push_back({"<div class=\"flag\">" + ImageTag(only, info.name()) + "</div>",
                    "<span class=\"key\" style=\"background:" + Hex(info.colour) + "\"></span><b>" +
                        info.name() + "</b>",
                    "<span class=\"nowrap\">" + Percent(SharePixels(flags, info.flag), 3) + "</span>",
                    EscapeHtml(info.meaning)});
  }
  const std::string map = "<figure><figcaption><b>All flags</b></figcaption>" +
                          ImageTag(composite, "all flags") +
                          "<p class=\"note\"><span class=\"key\" style=\"background:" + Hex(kNoFlag) +
                          "\"></span>no flag</p></figure>\n";
  return Section("flags", "Flags", lead, Grid(map + "<div>" + DrawTable(rows) + "</div>\n", 2));
}

namespace {

constexpr std::size_t kShownCandidates = 10;

// The sets of free parameters that were weighed, the chosen one first.
std::string CandidateTable(const FitResult& fit) {
  if (fit.candidates.empty()) return {};
  std::vector<std::vector<std::string>> rows{{"free", "absent (0)", "log evidence, 0 for the best"}};
  for (const Candidate& candidate : fit.candidates) {
    if (rows.size() > kShownCandidates) break;
    const std::string names = EscapeHtml(NamesOf(candidate.free));
    rows.push_back({rows.size() == 1 ? "<b>" + names + "</b> (chosen)" : names,
                    EscapeHtml(NamesOf(candidate.absent)), FormatValue(candidate.log_evidence, 3)});
  }
  return "<h3>What the data carry</h3>\n<p class=\"note\">An unknown is free where it brings the evidence of "
         "20 to 1; what is neither free nor absent has average skin's value.</p>\n" +
         DrawTable(rows);
}

}  // namespace

std::string DecisionsSection(const ReportContext& context) {
  std::string body;
  for (const std::string& decision : context.fit().decisions)
    body += "<li>" + EscapeHtml(decision) + "</li>\n";
  body = body.empty() ? "<p class=\"note\">None were recorded.</p>\n"
                      : "<ul class=\"sentences\">" + body + "</ul>\n";
  body += CandidateTable(context.fit());
  return Section("decisions", "Decisions", "What the program decided by itself, and why.", body);
}

std::string HowToReadSection() {
  constexpr std::pair<const char*, const char*> kTerms[] = {
      {"Reflectance",
       "The share of the light falling on the skin that leaves it again after scattering inside. The mirror "
       "reflection of the surface is not in it. 1 is all of it, 0.01 is 1 %."},
      {"Parameter maps",
       "C_m: melanin, as a volume fraction of the epidermis. beta_m: the share of it that is eumelanin "
       "(dark brown) rather than pheomelanin (red-yellow). C_he and C_hd: blood in epidermis and dermis, as "
       "volume fractions of whole blood at 150 g/L. C_bc: carotene in g/L."},
      {"Error bar, sigma",
       "One standard deviation of what is not known about a value: the noise of the measurement, and detail "
       "that the skin's blur hides. Residuals larger than the noise widen it. It does not know of errors of "
       "the model that the parameters can imitate: a small residual proves little about them."},
      {"Residual",
       "Measured minus predicted reflectance. Blue: measured darker than predicted; red: brighter. Structure "
       "that resembles the skin means that the model cannot follow; grain like noise is what remains at "
       "best."},
      {"chi2 per degree of freedom",
       "The squared residual in units of the noise. About 1: the prediction is as good as the "
       "data allow. Much more: the model or the calibration misses something. Much less: the "
       "stated noise is too large."},
      {"Not identifiable",
       "The data cannot tell this value, for instance the blood of the dermis beneath dark melanin. The "
       "map then shows what average skin suggests; do not read it as a measurement."},
      {"Colour bars",
       "They run from the 1st to the 99th percentile of the values, differences symmetrically about 0. Arrow "
       "heads at an end mean that some values lie beyond; pixels without a value are pink."},
      {"Colour pictures",
       "Computed for daylight (CIE D65) from the few measured bands, joined by straight lines and constant "
       "beyond the first and last one: true in character, not colorimetric."},
  };
  std::string body = "<dl>";
  for (const auto& [term, meaning] : kTerms) {
    body += "<dt>" + EscapeHtml(term) + "</dt><dd>" + EscapeHtml(meaning) + "</dd>\n";
  }
  return Section("reading", "How to read this page", "", body + "</dl>\n");
}

}  // namespace dermap
