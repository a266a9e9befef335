// SPDX-License-Identifier: Apache-2.0
// Takes frames: expose, fetch, verify, write. While one is exposed and fetched, the one before it is verified
// and written, so that the camera never waits for the disk. Where there is time before the next exposure, as
// while a flash recycles, the one before is settled first, and what was bad is taken again at once.
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/camera_setter.h"
#include "acquire/exposure_advice.h"
#include "acquire/frame_doubts.h"
#include "acquire/light_memory.h"
#include "acquire/sequence.h"
#include "acquire/session_folder.h"
#include "acquire/wheel_mover.h"
#include "common/core/error.h"

namespace dermap {

// A frame that was bad as often as it may be: perhaps not the one that is being taken, but the one before it.
class FrameGivenUp : public DeviceError {
 public:
  FrameGivenUp(int number, const std::string& what) : DeviceError(what), number_(number) {}
  int number() const { return number_; }

 private:
  int number_;
};

class FrameTaker {
 public:
  FrameTaker(SessionFolder& folder, Station& station, const CaptureOptions& options, CaptureSummary& summary,
             const Stopwatch& stopwatch);

  // Exposes and fetches it; then it is under way until it is settled. `slot_after`: where the wheel is wanted
  // next (0: nowhere). Where the frame before turns out bad in time, it returns without exposing. Throws
  // DeviceError for a fault that lasts, FrameGivenUp for a frame that was bad three times.
  void Take(const FrameRecord& planned, int slot_after);
  // Brings the frame under way to its end: it is in the folder, or to be taken again.
  void Settle();
  FrameDoubts& doubts() { return doubts_; }
  int under_way() const { return pending_ ? pending_->planned.number : 0; }  // 0: none

  LightMemory& light() { return light_; }
  void Warn(const std::string& warning);
  WheelMover& wheel() { return wheel_; }
  CameraSetter& setter() { return setter_; }
  bool schedule_changed() const { return schedule_changed_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Examination {
    FrameCheck check;
    std::string sha256;
    TimeSpan span;
  };
  struct Pending {
    FrameRecord planned;
    RawFrame raw;
    std::string time_utc;
    std::size_t timing = 0;  // its place in the timeline
    std::future<Examination> examining;
    std::optional<Examination> found;
  };
  struct Verdict {
    std::string problem;  // empty: it is good
    bool wrong_settings = false;
    LightJudgement light;
    ExposureAdvice advice;
  };
  bool Prepare(const FrameRecord& planned);                      // false: the frame before was bad
  std::string Expose(const FrameRecord& planned);                // returns when, in UTC
  std::string Fetch(const FrameRecord& planned, RawFrame& raw);  // returns how it was lost; empty: it was not
  void Examine(std::unique_ptr<Pending> taken);
  // Puts the frame under way into the folder where it is good beyond doubt: asks nothing of any device.
  bool KeepIfGood();
  Verdict Judge(Pending& pending);  // waits for its examination
  void Reject(int number, const std::string& problem);
  void ActOn(Pending& pending, const Verdict& verdict);
  void Withdraw(int number, const std::string& why);
  bool Adapt(const FrameRecord& planned, const ExposureAdvice& advice);  // false: the frame is to be kept
  std::optional<int> IsoThatCameraTakes(const FrameRecord& planned, const std::vector<int>& isos);
  void Keep(const Pending& pending, const Verdict& verdict);
  bool IsTolerable(LightProblem problem, const FrameRecord& planned) const;
  bool IsStillPlanned(const Pending& pending) const;
  FrameTiming& Timing() { return summary_.timeline.frames.back(); }
  void Step(const std::string& what, const FrameRecord& frame);

  SessionFolder& folder_;
  Station& station_;
  const CaptureOptions& options_;
  CaptureSummary& summary_;
  const Stopwatch& stopwatch_;
  WheelMover wheel_;
  CameraSetter setter_;
  LightMemory light_;
  std::unique_ptr<Pending> pending_;  // the frame under way
  FrameDoubts doubts_;
  std::optional<Clock::time_point> flash_ready_;
  std::optional<Clock::duration> quickest_press_;  // from asking the camera to its answer
  double progress_ = 0.0;
  bool schedule_changed_ = false;
};

// Share of the progress that making the devices takes: rendering the scene.
inline constexpr double kShareOfPreparation = 0.5;

}  // namespace dermap
