// SPDX-License-Identifier: Apache-2.0
// Places the report's charts and brings their colours along.
#include "studies/chart_sheet.h"

#include <fmt/format.h>

#include <algorithm>

#include "fit/report_parts.h"

namespace dermap {
namespace {

constexpr int kGap = 26, kTitle = 26;  // px

// The report's chart classes with fixed colours: not every reader of SVG knows variables.
std::string Style() {
  constexpr const char* kColours[] = {"#1f2328", "#0072b2", "#d55e00", "#009e73", "#b0579a", "#8a6d00"};
  std::string style = R"css(
svg { font: 12px "DejaVu Sans", "Segoe UI", Roboto, sans-serif; }
.axis { stroke: #5b626b; } .grid { stroke: #e9e7e2; } .reference { stroke: #5b626b; stroke-dasharray: 3 4; }
text { fill: #5b626b; } .label, .legend { fill: #1f2328; font-size: 12.5px; }
.title { fill: #1f2328; font-size: 15px; font-weight: bold; }
.mid { text-anchor: middle; } .end { text-anchor: end; }
.curve { fill: none; stroke-width: 2; stroke-linejoin: round; } .dashed { stroke-dasharray: 6 4; }
.whisker { stroke-width: 1.5; }
)css";
  for (int i = 0; i < 6; ++i) {
    style +=
        fmt::format(".s{0} {{ stroke: {1}; }} .dot.s{0} {{ fill: {1}; stroke: #ffffff; }}\n", i, kColours[i]);
  }
  return style;
}

}  // namespace

std::string DrawChartSheet(const std::vector<TitledChart>& charts, int columns) {
  int width = 0;
  for (const TitledChart& titled : charts) width = std::max(width, titled.chart.width);
  std::string body;
  int top = kGap;
  for (std::size_t row = 0; row < charts.size(); row += columns) {
    int height = 0;
    for (std::size_t i = row; i < std::min(charts.size(), row + columns); ++i) {
      const TitledChart& titled = charts[i];
      const int left = kGap + static_cast<int>(i - row) * (width + kGap);
      std::string svg = DrawChart(titled.chart);
      const std::string element = "<svg ";
      const std::string placed = fmt::format(R"(<svg x="{}" y="{}" width="{}" height="{}" )", left,
                                             top + kTitle, titled.chart.width, DrawnHeight(titled.chart));
      if (svg.starts_with(element)) svg.replace(0, element.size(), placed);
      body += fmt::format(R"(<text class="title" x="{}" y="{}">{}</text>)", left, top + 10,
                          EscapeHtml(titled.title));
      body += svg;
      height = std::max(height, DrawnHeight(titled.chart));
    }
    top += kTitle + height + kGap;
  }
  const int full_width = kGap + columns * (width + kGap);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"sheet\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">\n"
      "<style>{2}</style>\n<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n{3}</svg>\n",
      full_width, top, Style(), body);
}

}  // namespace dermap
