// SPDX-License-Identifier: Apache-2.0
// Time against error on logarithmic axes, as SVG: dots by family, the front drawn through, some named.
#pragma once

#include <string>
#include <vector>

namespace dermap {

struct ScatterPoint {
  double x = 0.0, y = 0.0;          // positive; others are left out
  double x_bar = 0.0, y_bar = 0.0;  // half lengths, in the axes' units
  int family = 0;                   // index into ScatterChart::families
  std::string label;                // beside the point; empty: none
  std::string title;                // shown under the mouse
  bool star = false;                // the shipped default
  bool hollow = false;              // extrapolated
};

struct ScatterChart {
  std::string title, x_label, y_label;
  std::string note;    // a sentence beneath the title
  double level = 0.0;  // a horizontal line with its name; 0: none
  std::string level_name;
  std::vector<std::string> families;  // at most six
  std::vector<ScatterPoint> points;
  std::vector<std::size_t> front;  // into points, by x
};

// Charts in `columns`, with `footer` beneath.
std::string DrawScatterSheet(const std::vector<ScatterChart>& charts, int columns, const std::string& footer);

}  // namespace dermap
