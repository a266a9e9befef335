// SPDX-License-Identifier: Apache-2.0
// A camera that counts how often it is set, and fails on demand.
#include "acquire/camera_setter.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/core/error.h"

namespace dermap {
namespace {

class CountingCamera : public Camera {
 public:
  std::string Name() const override { return "counting camera"; }
  std::uintmax_t FrameBytes() const override { return 1; }
  void MakeReady(const CaptureSettings& settings) override {
    setter = std::this_thread::get_id();
    iso = settings.iso;
    if (++times <= failures) throw DeviceError("is busy");
  }
  std::chrono::steady_clock::time_point Expose(const CaptureSettings&) override { return {}; }
  RawFrame Fetch() override { return {}; }

  int times = 0, failures = 0, iso = 0;
  std::thread::id setter;
};

TEST(CameraSetter, SetsAheadOfTimeBesideWhoeverWaits) {
  const Stopwatch stopwatch;
  CountingCamera camera;
  {
    CameraSetter setter(camera, stopwatch);
    setter.Start({10.0, 200, 1});
  }
  EXPECT_EQ(camera.times, 1);
  EXPECT_NE(camera.setter, std::this_thread::get_id());
}

TEST(CameraSetter, SetsForTheFrameThatComesWhateverWasSetAhead) {
  const Stopwatch stopwatch;
  CountingCamera camera;
  CameraSetter setter(camera, stopwatch);
  setter.Start({10.0, 200, 1});
  setter.Finish({10.0, 400, 2});
  EXPECT_EQ(camera.iso, 400);
}

// Nobody is there to hear of it: it counts where the frame needs it, if it lasts.
TEST(CameraSetter, ThrowsOnlyWhatLasts) {
  const Stopwatch stopwatch;
  CountingCamera camera;
  CameraSetter setter(camera, stopwatch);
  camera.failures = 1;
  setter.Start({10.0, 200, 1});
  EXPECT_NO_THROW(setter.Finish({10.0, 200, 1}));
  camera.failures = 9;
  setter.Start({10.0, 200, 1});
  EXPECT_THROW(setter.Finish({10.0, 200, 1}), DeviceError);
}

}  // namespace
}  // namespace dermap
