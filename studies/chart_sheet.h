// SPDX-License-Identifier: Apache-2.0
// Charts side by side in one SVG that needs no page and no style sheet.
#pragma once

#include <string>
#include <vector>

#include "fit/report_chart.h"

namespace dermap {

struct TitledChart {
  std::string title;
  Chart chart;
};

// Rows of `columns` charts on white, each with its title.
std::string DrawChartSheet(const std::vector<TitledChart>& charts, int columns);

}  // namespace dermap
