// SPDX-License-Identifier: Apache-2.0
// A study that was broken off goes on where it was.
#include "studies/point_journal.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/core/error.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

// Source: what the header promises; the second point fails in the first run.
TEST(PointJournal, MeasuresNoPointTwice) {
  const TemporaryFolder folder;
  int calls = 0;
  bool broken = true;
  const auto point = [&](int value) {
    return PlannedPoint{std::to_string(value), 1.0, [&calls, &broken, value] {
                          if (broken && value == 2) throw std::runtime_error("power cut");
                          ++calls;
                          return nlohmann::json{{"value", value}};
                        }};
  };
  const std::vector<PlannedPoint> plan{point(1), point(2), point(3)};
  const nlohmann::json settings{{"seed", 1}};
  EXPECT_THROW(RunPoints(folder.path(), "study", settings, plan, {}), std::runtime_error);
  broken = false;
  double last = 0.0;
  const PointRun run = RunPoints(folder.path(), "study", settings, plan, [&](double f) { last = f; });
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(run.resumed, 1);
  EXPECT_EQ(run.measured, 2);
  EXPECT_EQ(last, 1.0);
  ASSERT_EQ(run.records.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(run.records[i]["value"], i + 1);
  EXPECT_THROW(RunPoints(folder.path(), "study", {{"seed", 2}}, plan, {}), InputError);
  EXPECT_THROW(ReadRecords(run, [](const nlohmann::json& record) { record.at("other"); }), InputError);
}

}  // namespace
}  // namespace dermap
