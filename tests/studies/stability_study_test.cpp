// SPDX-License-Identifier: Apache-2.0
// Sweeps whose verdicts must hold, and how their points are counted.
#include "studies/stability_study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

StabilityPoint PointOf(double error, double sigma) {
  StabilityPoint point;
  for (ParameterStability& p : point.parameters) p = {true, error, 1.0, sigma, error, 1.0, 2.0 * error};
  return point;
}

// Definition: twice the harmless error where noise allows the same is an excess of 2; where noise allows
// twice as much, 1.
TEST(StabilityPoint, ExcessIsOverWhatNoiseAllows) {
  const StabilityPoint harmless = PointOf(0.1, 0.15);
  StabilityPoint point = PointOf(0.2, 0.15);
  Relate(harmless, point);
  EXPECT_NEAR(point.excess, 2.0, 1e-12);
  for (ParameterStability& p : point.parameters) p.bound = 2.0;
  Relate(harmless, point);
  EXPECT_NEAR(point.excess, 1.0, 1e-12);
}

TEST(StabilityPoint, ATenthOfThePixelsIsEnoughToBeWrong) {
  StabilityPoint point = PointOf(0.1, 0.15);
  for (ParameterStability& p : point.parameters) p.decile = 0.6;
  Relate(PointOf(0.1, 0.15), point);
  EXPECT_NEAR(point.excess, 3.0, 1e-12);
}

// A parameter that is not free and by chance exactly right has neither error nor sigma.
TEST(StabilityPoint, ExcessOfNothingIsANumber) {
  StabilityPoint harmless = PointOf(0.1, 0.15), point = PointOf(0.1, 0.15);
  harmless.parameters[2] = point.parameters[2] = {false, 0.0, 1.0, 0.0, 0.0, 1.0};
  Relate(harmless, point);
  EXPECT_NEAR(point.excess, std::sqrt(0.8), 1e-9);
}

TEST(StabilityPoint, SaysWhatTheProgramDid) {
  StabilityPoint point = PointOf(0.01, 0.01);
  EXPECT_EQ(Response(point), "wide intervals");
  point.flagged = 0.9;
  EXPECT_EQ(Response(point), "flagged");
  point.silently_wrong = true;
  EXPECT_EQ(Response(point), "silent");
  point.refusal = "no";
  EXPECT_EQ(Response(point), "refused");
}

// A pixel that is flagged has at least one flag. Freckled skin in eight bands without a fault is told; what
// lies beyond table 1 is flagged.
void ExpectFlagsAddUp(const StabilityStudy& study) {
  for (const StabilityPoint& p : study.points) {
    double sum = 0.0, most = 0.0;
    for (const auto& [name, share] : p.flags) sum += share, most = std::max(most, share);
    EXPECT_LE(most, p.flagged + 1e-12) << p.sweep << " " << p.value;
    EXPECT_GE(sum, p.flagged - 1e-12) << p.sweep << " " << p.value;
    if (p.sweep == "drift" && p.value == 0.0) {
      EXPECT_LE(p.told_flagged, kFlaggedInside);
    }
    if (p.sweep == "melanin" && p.value == 1.0) {
      EXPECT_GT(p.flagged, 0.5);
    }
  }
}

// Source of the truths: adding-doubling for the skins; the forward model at its most exact for the others.
// Whatever these sweeps do, the fit must not be silently wrong, nor flag what is right but where said.
TEST(StabilityStudy, FastIsNeverSilentlyWrongHere) {
  const TemporaryFolder folder;
  StabilityStudyOptions options{
      .quick = true,
      .sweeps = {"melanin", "gain", "drift", "noise", "misregistration", "pixel_size", "wrong_thickness"},
      .methods = {}};
  const StabilityStudy study = RunStabilityStudy(folder.path(), options, {});
  EXPECT_TRUE(study.silently_wrong.empty());
  for (const std::size_t i : study.flagged_inside)
    ADD_FAILURE() << study.points[i].sweep << " " << study.points[i].value << " is right, yet flagged";
  ExpectFlagsAddUp(study);
  int edges = 0;
  for (const StabilityEdge& edge : study.edges) edges += edge.found;
  EXPECT_GE(edges, 3);  // or it could not tell: melanin beyond table 1, drift, displaced bands
  WriteStabilityStudy(folder.path(), study);
  const auto json = nlohmann::json::parse(ReadTextFile(folder.path() / "stability.json"));
  EXPECT_EQ(json["points"].size(), study.points.size());
  EXPECT_EQ(json["silently_wrong"], study.silently_wrong.size());

  // Broken off after three points, it goes on and ends the same.
  std::ifstream whole(folder.path() / "stability.journal.jsonl");
  const TemporaryFolder again;
  std::ofstream part(again.path() / "stability.journal.jsonl");
  std::string line;
  for (int i = 0; i < 4 && std::getline(whole, line); ++i) part << line << '\n';
  part.close();
  const StabilityStudy resumed = RunStabilityStudy(again.path(), options, {});
  ASSERT_EQ(resumed.points.size(), study.points.size());
  for (std::size_t i = 0; i < study.points.size(); ++i)
    EXPECT_EQ(resumed.points[i].excess, study.points[i].excess) << i;
}

// Points that were counted otherwise are not mixed with these.
TEST(StabilityStudy, RefusesAJournalOfAnotherVersion) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "stability.journal.jsonl")
      << R"({"settings":{"quick":true,"seed":1,"study":"stability"}})" << '\n';
  EXPECT_THROW(RunStabilityStudy(folder.path(), {.quick = true, .sweeps = {"melanin"}, .methods = {}}, {}),
               InputError);
}

TEST(StabilityStudy, NamesTheSweepsThatItKnows) {
  const TemporaryFolder folder;
  EXPECT_THROW(RunStabilityStudy(folder.path(), {.quick = true, .sweeps = {"weather"}, .methods = {}}, {}),
               InputError);
}

}  // namespace
}  // namespace dermap
