// SPDX-License-Identifier: Apache-2.0
// The emulated flash: a frame through the opaque slot, which no light passes, is what dark looks like.
#include "acquire/emulator/light_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "acquire/frame_check.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

constexpr double kDark = 0.05;  // of the range, as the black level alone is

class EmulatedFlash : public testing::Test {
 protected:
  EmulatedFlash() {
    folder_.Write("scene.toml", acquire_test::SmallSceneToml());
    rig_ = ReadRig(folder_.Write("rig.toml", acquire_test::SmallRigToml("scene.toml")));
  }
  double LevelOf(emulator::LightPath& path) {
    const emulator::Bytes file = path.Expose(10.0, 100)();
    RawFrame frame{std::vector<std::byte>(file.size()), ".dng"};
    std::transform(file.begin(), file.end(), frame.bytes.begin(), [](auto b) { return std::byte{b}; });
    return CheckFrame(frame, rig_.gray_card_region).level;
  }
  acquire_test::TemporaryFolder folder_;
  RigConfig rig_;
  emulator::WheelMotion wheel_{3, 0.0};  // stands at slot 1, 540 nm
};

TEST_F(EmulatedFlash, StaysDarkWhereItIsFiredTooEarly) {
  emulator::LightPath path(rig_, wheel_, 1000.0);
  path.target = FrameRole::kSpectralon;
  EXPECT_GT(LevelOf(path), kDark);
  EXPECT_LT(LevelOf(path), kDark);
}

TEST_F(EmulatedFlash, FiresAgainOnceItHasRecycled) {
  emulator::LightPath path(rig_, wheel_, 0.01);
  path.target = FrameRole::kSpectralon;
  EXPECT_GT(LevelOf(path), kDark);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_GT(LevelOf(path), kDark);
}

}  // namespace
}  // namespace dermap
