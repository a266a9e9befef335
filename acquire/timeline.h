// SPDX-License-Identifier: Apache-2.0
// Where the time of a session went, device by device, and what the slowest of them needed by itself: no order
// of steps can take less.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace dermap {

// Tells seconds since it was made: the session's first step.
class Stopwatch {
 public:
  double Now() const { return At(std::chrono::steady_clock::now()); }
  double At(std::chrono::steady_clock::time_point time) const {
    return std::chrono::duration<double>(time - start_).count();
  }

 private:
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Seconds of a stopwatch.
struct TimeSpan {
  double start_s = 0.0;
  double end_s = 0.0;
  double seconds() const { return end_s > start_s ? end_s - start_s : 0.0; }
};

// One exposure. The wheel's move for the next frame and the flash's recycling run beside the fetching of this
// one; its check and its writing may run beside the next exposure.
struct FrameTiming {
  int number = 0;     // of the frame
  bool good = false;  // kept; else it was exposed again
  TimeSpan wheel;     // its move for this frame
  TimeSpan flash;     // recycling after this frame
  TimeSpan ready;     // setting the camera for it
  TimeSpan expose, fetch, check, write;
};

struct SessionTimeline {
  std::vector<FrameTiming> frames;
  std::vector<TimeSpan> waits;  // for the operator
};

struct ChainTimes {
  double camera_s = 0.0;  // being set, exposing and fetching
  double wheel_s = 0.0;   // moving
  double flash_s = 0.0;   // recycling between two frames, where the operator is not waited for
  double turns_s =
      0.0;  // exposures, and between two of them the slowest device: none may move while one exposes
  double taken_s = 0.0;  // from the first step of the first frame to the end of the last, without the waits
  double slowest_s() const;  // of camera, wheel and flash
  double overhead() const;   // how much longer it took than the slowest device alone: 0.05 is 5 %
};
ChainTimes AddUp(const SessionTimeline& timeline);

// A chart of it: one row a device, time from left to right.
std::string TimelineSvg(const SessionTimeline& timeline);

}  // namespace dermap
