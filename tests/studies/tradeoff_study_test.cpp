// SPDX-License-Identifier: Apache-2.0
// Speed against accuracy: what holds on any machine. Times are never asserted.
#include "studies/tradeoff_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

TradeoffPoint Point(const char* scene, const char* setting, double ratio, double error) {
  TradeoffPoint p{.kind = "render", .scene = scene, .setting = setting, .family = "family"};
  p.seconds = 2.0 * ratio;  // the yardstick took 2 s
  p.ratio = ratio;
  p.error = error;
  p.is_default = std::string(setting) == "default";
  return p;
}

// Source: the definitions, worked by hand.
TEST(TradeoffCharts, KnowTheFrontAndWhoBeatsTheDefault) {
  const auto charts = ChartsOf({Point("one", "default", 1.0, 1e-3), Point("one", "slow", 5.0, 1e-4),
                                Point("one", "fast", 0.5, 1e-2), Point("two", "default", 1.0, 1e-3),
                                Point("two", "better", 0.5, 1e-4)});
  ASSERT_EQ(charts.size(), 2u);
  EXPECT_EQ(charts[0].front, (std::vector<std::size_t>{2, 0, 1}));
  EXPECT_TRUE(charts[0].shipped_on_front);
  EXPECT_EQ(charts[0].shipped_beaten_by, "");
  EXPECT_DOUBLE_EQ(charts[0].dots[1].seconds, 10.0);
  EXPECT_FALSE(charts[1].shipped_on_front);
  EXPECT_EQ(charts[1].shipped_beaten_by, "better");
}

// Source: geometric means by hand; a setting that one scene lacks is not put together.
TEST(TradeoffCharts, PutScenesTogether) {
  const auto charts =
      ChartsOfAllScenes({Point("one", "default", 1.0, 1e-3), Point("two", "default", 4.0, 1e-5),
                         Point("two", "alone", 1.0, 1e-3)});
  ASSERT_EQ(charts.size(), 1u);
  ASSERT_EQ(charts[0].dots.size(), 1u);
  EXPECT_NEAR(charts[0].dots[0].seconds, 4.0, 1e-9);
  EXPECT_NEAR(charts[0].dots[0].error, 1e-4, 1e-12);
}

// What was measured, without times.
nlohmann::json WithoutTimes(const TradeoffStudy& study, const std::filesystem::path& folder) {
  WriteTradeoffStudy(folder, study);
  nlohmann::json points = nlohmann::json::parse(ReadTextFile(folder / "tradeoff.json"))["points"];
  for (nlohmann::json& point : points)
    for (const char* key : {"seconds", "ratio_to_default", "ratio_spread"}) point.erase(key);
  return points;
}

// Source: the verdicts; and a run that was broken off in the middle of a line goes on to the same result.
TEST(TradeoffStudy, HoldsAndGoesOnWhereItWasBrokenOff) {
  const TemporaryFolder folder;
  const TradeoffStudy study = RunTradeoffStudy(folder.path(), {.quick = true}, {});
  for (const Verdict& verdict : study.verdicts)
    EXPECT_TRUE(verdict.holds()) << verdict.claim << ": " << verdict.worst;
  EXPECT_EQ(study.resumed, 0);
  const nlohmann::json whole = WithoutTimes(study, folder.path());
  for (const char* file : {"tradeoff.csv", "tradeoff.svg", "tradeoff.html"})
    EXPECT_TRUE(std::filesystem::exists(folder.path() / file)) << file;

  const auto journal = folder.path() / "tradeoff.journal.jsonl";
  const std::string lines = ReadTextFile(journal);
  const std::size_t cut = lines.find("\"fit monte_carlo_skin");
  ASSERT_NE(cut, std::string::npos);
  std::ofstream(journal, std::ios::trunc) << lines.substr(0, cut);
  const TradeoffStudy again = RunTradeoffStudy(folder.path(), {.quick = true}, {});
  EXPECT_GT(again.resumed, 30);
  EXPECT_LT(again.resumed, static_cast<int>(again.points.size()));
  EXPECT_EQ(WithoutTimes(again, folder.path()), whole);
}

}  // namespace
}  // namespace dermap
