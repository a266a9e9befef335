// SPDX-License-Identifier: Apache-2.0
// Takes what a session folder lacks: place, move, expose, fetch, verify, write, frame by frame. While a frame
// is fetched and verified, the wheel already moves and the flash recycles.
#pragma once

#include <chrono>
#include <future>
#include <optional>

#include "acquire/exposure_advice.h"
#include "acquire/light_memory.h"
#include "acquire/sequence.h"
#include "acquire/session_folder.h"

namespace dermap {

class SessionRunner {
 public:
  SessionRunner(SessionFolder& folder, Station& station, const CaptureOptions& options,
                CaptureSummary& summary);
  ~SessionRunner();  // lets a move of the wheel come to its end
  void Run();

 private:
  using Clock = std::chrono::steady_clock;
  // How one exposure went: `problem` is empty where it is good and written.
  struct Attempt {
    std::string problem;
    bool exposure_changed = false;  // and so it is to be taken anew, at another ISO
  };
  void Preflight();
  void TakeFromReference();
  void LearnFromWhatIsThere();
  bool Retake();  // what was asked to be taken again; false: the session shall end
  bool Place(FrameRole role);
  bool TakePatiently(int number);  // false: the session shall end
  void Take(int number);
  Attempt TryOnce(const FrameRecord& planned, bool last_attempt);
  std::string Expose(const FrameRecord& planned, FrameTiming& timing);  // returns when, in UTC
  std::string Verify(const FrameRecord& planned, const RawFrame& raw, const FrameCheck& check,
                     LightJudgement& light, bool last_attempt);
  Attempt Adapt(const FrameRecord& planned, const ExposureAdvice& advice, bool last_attempt);
  std::optional<int> IsoThatCameraTakes(const FrameRecord& planned, const std::vector<int>& isos);
  void Keep(const FrameRecord& planned, const RawFrame& raw, const FrameCheck& check,
            const LightJudgement& light, const std::string& time_utc);
  void TellOfSchedule(const std::string& why);
  void Warn(const std::string& warning);
  void StartMove(int slot);
  void FinishMove(int slot);  // waits until the wheel stands there
  void HomeWheel();
  // What is still to take, the target in place first; `besides`: a frame that is under way.
  const FrameRecord* NextMissing(int besides = 0) const;
  const FrameRecord& Planned(int number) const;
  void Step(const std::string& what, const FrameRecord* frame);
  bool AskWhileTimeStands(const OperatorRequest& request);
  bool ShallStop();
  double Now() const;  // s since the session's first step

  SessionFolder& folder_;
  Station& station_;
  const CaptureOptions& options_;
  CaptureSummary& summary_;
  const Clock::time_point start_ = Clock::now();
  LightMemory light_;
  std::optional<FrameRole> placed_;
  std::future<void> move_;
  int moving_to_ = 0, stands_at_ = 0;
  TimeSpan wheel_span_;  // of the last move
  std::optional<Clock::time_point> flash_ready_;
  std::optional<Clock::duration> quickest_press_;  // from asking the camera to its answer
  int underexposed_ = 0;                           // the frame that looked so in its last attempt
  double progress_ = 0.0;
  bool schedule_changed_ = false;
};

}  // namespace dermap
