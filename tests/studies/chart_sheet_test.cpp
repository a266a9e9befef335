// SPDX-License-Identifier: Apache-2.0
// One picture of several charts that stands alone.
#include "studies/chart_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dermap {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TitledChart SomeChart(const std::string& title, int series_count) {
  TitledChart titled;
  titled.title = title;
  titled.chart.width = 300;
  titled.chart.height = 200;
  for (int i = 0; i < series_count; ++i) {
    ChartSeries series;
    series.name = "series";
    series.x = {1.0, 10.0, 100.0};
    series.y = {1.0, 2.0, 3.0};
    titled.chart.series.push_back(series);
  }
  return titled;
}

std::size_t CountOf(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

// Not every reader of SVG knows style variables or a page's style sheet; titles are text and must be escaped.
TEST(ChartSheet, NeedsNothingElse) {
  const std::string svg = DrawChartSheet({SomeChart("a < b", 1), SomeChart("c", 2), SomeChart("d", 1)}, 2);
  EXPECT_EQ(CountOf(svg, "<svg "), 4u);
  EXPECT_EQ(CountOf(svg, "</svg>"), 4u);
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
  EXPECT_THAT(svg, HasSubstr("xmlns=\"http://www.w3.org/2000/svg\""));
  EXPECT_THAT(svg, Not(HasSubstr("var(")));
}

// The sheet is as wide and as high as what it holds: 2 x 300 and three gaps of 26 px; two rows of title (26),
// chart (200) and legend (18 a line, two lines in the first row), and three gaps.
TEST(ChartSheet, HoldsAllOfItsCharts) {
  const std::string svg = DrawChartSheet({SomeChart("a", 1), SomeChart("b", 2), SomeChart("c", 1)}, 2);
  EXPECT_THAT(svg, HasSubstr("width=\"678\" height=\"584\""));
}

}  // namespace
}  // namespace dermap
