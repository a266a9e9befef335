// SPDX-License-Identifier: Apache-2.0
// Line charts as inline SVG for the report; colours come from the page's style sheet.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dermap {

struct ChartSeries {
  std::string name;  // in the legend; empty: not listed
  int colour = 0;    // 0: ink, 1...: the style sheet's series colours
  std::vector<double> x, y;
  std::vector<double> error;  // half length of error bars, as many as y, or empty
  bool line = true;
  bool dashed = false;
  bool markers = true;
};

struct Chart {
  std::string label;  // what a screen reader says
  std::string x_label;
  std::string y_label;
  bool log_x = false;                 // values that are not positive are left out
  bool log_y = false;                 // likewise
  std::optional<double> y_from;       // lowest value of a linear axis
  std::optional<double> reference_y;  // a dashed level with its name
  std::string reference_name;
  int width = 640;
  int height = 340;
  std::vector<ChartSeries> series;
};

// Height of the drawn element, legend included, for a width of chart.width.
int DrawnHeight(const Chart& chart);

// The SVG element, or a sentence where there is nothing to draw.
std::string DrawChart(const Chart& chart);

}  // namespace dermap
