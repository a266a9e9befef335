// SPDX-License-Identifier: Apache-2.0
// HTML building blocks of the report.
#include "fit/report_parts.h"

#include <fmt/format.h>

#include <cmath>

#include "fit/report_statistics.h"

namespace dermap {
namespace {

std::string CssPercent(double share) {
  return fmt::format("{:.2f}%", 100.0 * share);
}

// The bar as a picture of its own, since printers drop CSS backgrounds.
std::string BarImage(ColourMap map) {
  Plane<Rgb8> ramp(128, 1);
  for (int x = 0; x < ramp.width(); ++x) ramp(x, 0) = ColourAt(map, x / 127.0);
  return "<img class=\"ramp\" alt=\"\" src=\"" + DataUri(EncodePng(ramp)) + "\">";
}

std::string ColourBar(const PlaneF& plane, ColourMap map, const Scale& scale) {
  bool below = false, above = false, missing = false;
  const double slack = 1e-6 * (scale.high - scale.low);
  for (const float value : plane.values()) {
    missing = missing || !std::isfinite(value);
    below = below || value < scale.low - slack;
    above = above || value > scale.high + slack;
  }
  std::string html = "<div class=\"bar\">" + BarImage(map);
  const auto ticks = NiceTicks(scale.low, scale.high, 4);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : scale.high - scale.low;
  for (const double tick : ticks) {
    html += "<span class=\"tick\" style=\"left:" + CssPercent((tick - scale.low) / (scale.high - scale.low)) +
            "\">" + FormatTick(tick, step) + "</span>";
  }
  if (below) html += "<span class=\"beyond low\" title=\"some values are lower\">&#9664;</span>";
  if (above) html += "<span class=\"beyond high\" title=\"some values are higher\">&#9654;</span>";
  html += "</div>";
  if (missing) html += "<p class=\"note\"><span class=\"key missing\"></span>no value</p>";
  return html;
}

std::string LengthBar(double width_mm) {
  const auto lengths = NiceTicks(0.0, width_mm, 4);
  if (lengths.size() < 2) return {};
  return "<span class=\"length\" style=\"width:" + CssPercent(lengths[1] / width_mm) + "\">" +
         FormatValue(lengths[1]) + "&nbsp;mm</span>";
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string html;
  html.reserve(text.size());
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      case '\'':
        html += "&#39;";
        break;
      case '\n':
      case '\t':
        html += c;
        break;
      default:
        if (code < 0x20 || code == 0x7f) {
          html += "&#xFFFD;";
        } else {
          html += c;
        }
    }
  }
  return html;
}

std::string Percent(double share, int digits) {
  return std::isfinite(share) ? FormatValue(100.0 * share, digits) + " %" : "-";
}

std::string ImageTag(const Plane<Rgb8>& picture, std::string_view alternative_text) {
  return "<img class=\"pixels\" width=\"" + std::to_string(picture.width()) + "\" height=\"" +
         std::to_string(picture.height()) + "\" alt=\"" + EscapeHtml(alternative_text) + "\" src=\"" +
         DataUri(EncodePng(picture)) + "\">";
}

std::string DrawMapFigure(const PlaneF& plane, const MapFigure& options) {
  const Scale scale = options.scale.value_or(RobustScale(plane.values()));
  std::string html = "<figure><figcaption><b>" + EscapeHtml(options.heading) + "</b>";
  if (!options.unit.empty()) html += " <span class=\"unit\">" + EscapeHtml(options.unit) + "</span>";
  html += "</figcaption>" + ImageTag(Colourise(plane, options.map, scale), options.heading);
  if (options.bar) html += ColourBar(plane, options.map, scale);
  if (!options.note.empty()) html += "<p class=\"note\">" + EscapeHtml(options.note) + "</p>";
  return html + "</figure>\n";
}

std::string DrawColourFigure(const Plane<Rgb8>& picture, const std::string& heading, const std::string& note,
                             const std::vector<Marker>& markers, std::optional<double> pixel_size_mm) {
  std::string html = "<figure><figcaption><b>" + EscapeHtml(heading) +
                     "</b></figcaption><div class=\"stage\">" + ImageTag(picture, heading);
  for (const Marker& marker : markers) {
    html += "<span class=\"point\" style=\"left:" + CssPercent((marker.x + 0.5) / picture.width()) +
            ";top:" + CssPercent((marker.y + 0.5) / picture.height()) + "\"><i>" + EscapeHtml(marker.letter) +
            "</i></span>";
  }
  if (pixel_size_mm && *pixel_size_mm > 0.0) html += LengthBar(*pixel_size_mm * picture.width());
  html += "</div>";
  if (!note.empty()) html += "<p class=\"note\">" + EscapeHtml(note) + "</p>";
  return html + "</figure>\n";
}

std::string SpreadNote(const PlaneF& plane) {
  return "median " + FormatValue(QuantileOf(plane.values(), 0.5)) +
         "; 5 to 95 %: " + FormatValue(QuantileOf(plane.values(), 0.05)) + " to " +
         FormatValue(QuantileOf(plane.values(), 0.95));
}

std::string DrawTable(const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"wide\"><table>";
  for (std::size_t row = 0; row < rows.size(); ++row) {
    html += row == 0 ? "<thead><tr>" : row == 1 ? "<tbody><tr>" : "<tr>";
    for (const std::string& text : rows[row]) {
      html += row == 0 ? fmt::format("<th>{}</th>", text) : fmt::format("<td>{}</td>", text);
    }
    html += row == 0 ? "</tr></thead>" : "</tr>\n";
  }
  return html + (rows.size() > 1 ? "</tbody>" : "") + "</table></div>\n";
}

std::string Section(const std::string& id, const std::string& heading, const std::string& lead,
                    const std::string& body) {
  std::string html = "<section id=\"" + id + "\"><h2>" + EscapeHtml(heading) + "</h2>\n";
  if (!lead.empty()) html += "<p class=\"lead\">" + EscapeHtml(lead) + "</p>\n";
  return html + body + "</section>\n";
}

std::string Grid(const std::string& figures, int columns) {
  return "<div class=\"grid c" + std::to_string(columns) + "\">\n" + figures + "</div>\n";
}

}  // namespace dermap
