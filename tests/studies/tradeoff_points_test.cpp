// SPDX-License-Identifier: Apache-2.0
// Single points of time against error.
#include "studies/tradeoff_points.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace dermap {
namespace {

// Source: the tolerance that the default promises, and that the exact optics with both ends is closer to
// Monte Carlo than the published model.
TEST(TradeoffPoints, DefaultRenderKeepsItsToleranceAndBeatsThePaper) {
  TradeoffMeter meter(32, 1, 0.0);
  TradeoffPoint shipped, paper;
  for (const RenderSetting& setting : RenderSettings(32, true)) {
    if (setting.is_default) shipped = meter.Render(setting, "monte_carlo_skin");
    if (setting.is_paper) paper = meter.Render(setting, "monte_carlo_skin");
  }
  EXPECT_LE(shipped.error, 1e-3);
  EXPECT_GT(shipped.error_monte_carlo, 0.0);
  EXPECT_LT(shipped.error_monte_carlo, paper.error_monte_carlo);
  EXPECT_EQ(ToJson(TradeoffPointFromJson(ToJson(paper))), ToJson(paper));
  RecordProperty("shipped", ToJson(shipped).dump());
  RecordProperty("paper", ToJson(paper).dump());
}

}  // namespace
}  // namespace dermap
