// SPDX-License-Identifier: Apache-2.0
// Journals and manifests that something has damaged, at random but the same each time: resuming gives the
// whole session, or an InputError that names the file; never anything else.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "acquire/sequence.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

constexpr int kMutants = 120;

// Bytes changed, cut out, doubled; or a number, a string or a bracket put where it does not belong.
std::string Mutate(std::string text, std::mt19937& random) {
  const auto at = [&] { return random() % text.size(); };
  for (unsigned changes = 1 + random() % 3; changes > 0 && text.size() > 8; --changes) {
    switch (random() % 6) {
      case 0:
        text[at()] = static_cast<char>(random());
        break;
      case 1:
        text.erase(at(), 1 + random() % 40);
        break;
      case 2:
        text.insert(at(), text.substr(at(), 1 + random() % 200));
        break;
      case 3:
        text.resize(at());
        break;
      case 4: {
        const char* const kWords[]{"null", "-1",      "1e999", "\"\"",
                                   "{}",   "[[[[",    "true",  "99999999999999999999",
                                   "\n",   "\\u0000", "NaN",   "../../x"};
        text.insert(at(), kWords[random() % std::size(kWords)]);
        break;
      }
      default:
        if (const auto digit = text.find_first_of("0123456789", at()); digit != std::string::npos)
          text[digit] = static_cast<char>('0' + random() % 10);
    }
  }
  return text;
}

class Mutants : public testing::Test {
 protected:
  Mutants() {
    folder_.Write("scene.toml", acquire_test::SmallSceneToml());
    options_.rig = folder_.Write("rig.toml", acquire_test::SmallRigToml("scene.toml"));
    options_.plan = folder_.Write("plan.toml", acquire_test::SmallPlanToml());
    options_.out = folder_.path() / "whole";
    RunCapture(options_);
    options_.out = folder_.path() / "mutant";
    options_.resume = true;
  }
  void Restore() const {
    fs::remove_all(options_.out);
    fs::copy(folder_.path() / "whole", options_.out, fs::copy_options::recursive);
  }
  void Spoil(const char* name) {
    const std::string text = ReadTextFile(options_.out / name);
    std::ofstream(options_.out / name, std::ios::binary) << Mutate(text, random_);
  }

  acquire_test::TemporaryFolder folder_;
  CaptureOptions options_;
  std::mt19937 random_{11};
};

TEST_F(Mutants, OfAJournalAreResumedOrRefused) {
  int resumed = 0, refused = 0;
  for (int i = 0; i < kMutants; ++i) {
    Restore();
    Spoil("journal.jsonl");
    const std::string spoilt = ReadTextFile(options_.out / "journal.jsonl");
    try {
      const CaptureSummary summary = RunCapture(options_);
      EXPECT_TRUE(summary.session.complete) << spoilt;
      const Session session = ReadSession(options_.out);
      VerifyFrames(session);
      EXPECT_EQ(session.frames.size(), session.complete ? static_cast<std::size_t>(summary.total) : 0u);
      ++resumed;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("journal.jsonl"), std::string::npos) << error.what();
      // The frames stay where they are, for whoever mends the journal.
      EXPECT_EQ(std::distance(fs::directory_iterator(options_.out / "frames"), fs::directory_iterator{}),
                acquire_test::kSmallPlanFrames);
      ++refused;
    }
  }
  EXPECT_GT(resumed, 0);
  EXPECT_GT(refused, 0);
}

TEST_F(Mutants, OfAManifestAreReadOrRefused) {
  int read = 0, refused = 0;
  for (int i = 0; i < 4 * kMutants; ++i) {
    Restore();
    Spoil("session.json");
    try {
      VerifyFrames(ReadSession(options_.out));
      ++read;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(options_.out.string()), std::string::npos) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace dermap
