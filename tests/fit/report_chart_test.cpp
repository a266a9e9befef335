// SPDX-License-Identifier: Apache-2.0
// Charts put values where the axes say.
#include "fit/report_chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/fit/report/html_check.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Vertical position of the n-th dot, px.
double DotY(const std::string& svg, int n) {
  std::size_t at = 0;
  for (int i = 0; i <= n; ++i) at = svg.find("<circle", at) + 1;
  double y = NAN;
  std::sscanf(svg.c_str() + svg.find("cy=\"", at), "cy=\"%lf", &y);
  return y;
}

Chart ChartOf(std::vector<double> y) {
  Chart chart;
  chart.label = "label";
  ChartSeries series;
  for (std::size_t i = 0; i < y.size(); ++i) series.x.push_back(static_cast<double>(i));
  series.y = std::move(y);
  chart.series.push_back(std::move(series));
  return chart;
}

// A logarithm turns equal ratios into equal distances, a linear axis equal differences.
TEST(ReportChart, AxesAreLinearOrLogarithmic) {
  Chart chart = ChartOf({1.0, 10.0, 100.0});
  std::string svg = DrawChart(chart);
  EXPECT_NEAR((DotY(svg, 0) - DotY(svg, 1)) / (DotY(svg, 1) - DotY(svg, 2)), 0.1, 0.01);
  chart.log_y = true;
  svg = DrawChart(chart);
  EXPECT_NEAR((DotY(svg, 0) - DotY(svg, 1)) / (DotY(svg, 1) - DotY(svg, 2)), 1.0, 0.01);
  EXPECT_GT(DotY(svg, 0), DotY(svg, 2)) << "more is higher";
  EXPECT_THAT(NestingFaults(svg), IsEmpty());
}

// Likewise along x.
TEST(ReportChart, AcrossMayBeLogarithmic) {
  Chart chart = ChartOf({1.0, 2.0, 3.0, 4.0});
  chart.series[0].x = {0.0, 1.0, 10.0, 100.0};
  chart.log_x = true;
  const std::string svg = DrawChart(chart);
  EXPECT_EQ(CountOf(svg, "<circle"), 3) << "0 has no logarithm";
  std::vector<double> x;
  for (std::size_t at = svg.find("cx=\""); at != std::string::npos; at = svg.find("cx=\"", at + 1)) {
    x.push_back(std::atof(svg.c_str() + at + 4));
  }
  EXPECT_NEAR((x[1] - x[0]) / (x[2] - x[1]), 1.0, 0.01);
}

// The header's contract: values that cannot be drawn are left out; nothing at all is said in words.
TEST(ReportChart, LeavesOutWhatCannotBeDrawn) {
  Chart chart = ChartOf({1.0, NAN, -3.0, 0.0, 10.0});
  chart.log_y = true;
  const std::string svg = DrawChart(chart);
  EXPECT_EQ(CountOf(svg, "<circle"), 2);
  EXPECT_EQ(CountOf(svg, "nan"), 0);
  EXPECT_THAT(DrawChart(ChartOf({NAN})), HasSubstr("Nothing to draw"));
  EXPECT_THAT(DrawChart(Chart{}), HasSubstr("Nothing to draw"));
}

// One value, and a constant one, still have axes of some width.
TEST(ReportChart, DrawsDegenerateSeries) {
  for (const auto& y :
       {std::vector<double>{0.0}, std::vector<double>{5.0}, std::vector<double>{2.0, 2.0, 2.0}}) {
    const std::string svg = DrawChart(ChartOf(y));
    EXPECT_EQ(CountOf(svg, "<circle"), static_cast<int>(y.size()));
    EXPECT_EQ(CountOf(svg, "nan") + CountOf(svg, "inf"), 0);
  }
}

}  // namespace
}  // namespace dermap
