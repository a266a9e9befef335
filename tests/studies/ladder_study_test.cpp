// SPDX-License-Identifier: Apache-2.0
// No more model than a scene needs, and what that costs.
#include "studies/ladder_study.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

// Source: the same engine at a tolerance of 1e-5; the definition of the rungs; and a run that was broken off
// in the middle goes on to the same result.
TEST(LadderStudy, HoldsAndGoesOnWhereItWasBrokenOff) {
  const TemporaryFolder folder;
  const LadderStudy study = RunLadderStudy(folder.path(), {.quick = true}, {});
  for (const Verdict& verdict : study.verdicts)
    EXPECT_TRUE(verdict.holds()) << verdict.claim << ": " << verdict.worst;
  ASSERT_EQ(study.scenes.size(), 5u);
  EXPECT_EQ(RungsInWords(study.scenes[0]), "8 local");
  EXPECT_EQ(RungsInWords(study.scenes[1]), "8 homogeneous");
  EXPECT_EQ(RungsInWords(study.scenes.back()), "8 full");
  EXPECT_GT(study.full_paths, 4);
  WriteLadderStudy(folder.path(), study);
  for (const char* file : {"ladder.csv", "ladder.json", "ladder.svg", "ladder.html"})
    EXPECT_TRUE(std::filesystem::exists(folder.path() / file)) << file;

  const auto journal = folder.path() / "ladder.journal.jsonl";
  const std::string lines = ReadTextFile(journal);
  std::ofstream(journal, std::ios::trunc) << lines.substr(0, lines.find("\"freckles x1.4") + 5);
  const LadderStudy again = RunLadderStudy(folder.path(), {.quick = true}, {});
  EXPECT_EQ(again.resumed, 3);
  ASSERT_EQ(again.scenes.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(again.scenes[i].name, study.scenes[i].name);
    EXPECT_EQ(again.scenes[i].error, study.scenes[i].error);
    EXPECT_EQ(again.scenes[i].estimate, study.scenes[i].estimate);
  }
}

}  // namespace
}  // namespace dermap
