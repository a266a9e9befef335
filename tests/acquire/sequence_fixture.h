// SPDX-License-Identifier: Apache-2.0
// Small sessions on the simulated station, in a folder that vanishes, and when one counts as whole; and what
// all tests of sessions include.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "acquire/sequence.h"
#include "acquire/simulated/simulated_station.h"
#include "common/core/error.h"
#include "tests/acquire/support.h"

namespace dermap::acquire_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Sequence : public testing::Test {
 protected:
  Sequence() {
    folder_.Write("scene.toml", SmallSceneToml());
    options_.rig = folder_.Write("rig.toml", SmallRigToml("scene.toml"));
    options_.plan = folder_.Write("plan.toml", SmallPlanToml());
    options_.out = folder_.path() / "session";
  }

  // Hash of every frame of a session that nothing disturbs.
  std::vector<std::string> Undisturbed() {
    CaptureOptions options = options_;
    options.out = folder_.path() / "undisturbed";
    std::vector<std::string> hashes;
    for (const FrameRecord& f : RunCapture(options).session.frames) hashes.push_back(f.sha256);
    return hashes;
  }

  void ExpectWhole(const std::vector<std::string>& hashes) {
    const Session session = ReadSession(options_.out);
    EXPECT_TRUE(session.complete);
    ASSERT_EQ(session.frames.size(), hashes.size());
    for (std::size_t i = 0; i < hashes.size(); ++i) EXPECT_EQ(session.frames[i].sha256, hashes[i]) << i;
    VerifyFrames(session);
    // Nothing else lies in frames/: no temporary file, no second copy.
    const auto files =
        std::distance(fs::directory_iterator(options_.out / "frames"), fs::directory_iterator{});
    EXPECT_EQ(files, static_cast<std::ptrdiff_t>(hashes.size()));
  }

  // The simulated station of the rig, watched: a new one each time.
  WatchedStation& Watch() {
    simulated_ = std::make_unique<SimulatedStation>(ReadRig(options_.rig));
    watched_ = std::make_unique<WatchedStation>(*simulated_);
    return *watched_;
  }

  template <class Exception>
  std::string MessageOf(const CaptureOptions& options) {
    try {
      RunCapture(options);
    } catch (const Exception& e) {
      return e.what();
    }
    return "no error";
  }

  TemporaryFolder folder_;
  CaptureOptions options_;
  std::unique_ptr<SimulatedStation> simulated_;
  std::unique_ptr<WatchedStation> watched_;
};

}  // namespace dermap::acquire_test
