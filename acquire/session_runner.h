// SPDX-License-Identifier: Apache-2.0
// Takes what a session folder lacks: place, move, expose, fetch, verify, write, frame by frame. While a frame
// is fetched and verified, the wheel already moves and the flash recycles.
#pragma once

#include <chrono>
#include <future>
#include <optional>

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
  void Preflight();
  void TakeFromReference();
  void LearnFrom(const FrameRecord& frame, const RawFrame& raw);
  bool Retake();  // what was asked to be taken again; false: the session shall end
  bool Place(FrameRole role);
  bool TakePatiently(const FrameRecord& planned);  // false: the session shall end
  void Take(const FrameRecord& planned);
  // One exposure; empty where it is good and written, else what is wrong with it.
  std::string TryOnce(const FrameRecord& planned, bool last_attempt);
  std::string Verify(const FrameRecord& planned, const RawFrame& raw, const FrameCheck& check,
                     LightJudgement& light, bool last_attempt);
  void Keep(const FrameRecord& planned, const RawFrame& raw, const FrameCheck& check,
            const LightJudgement& light, const FrameTiming& timing, const std::string& time_utc);
  void StartMove(int slot);
  void FinishMove(int slot);                                  // waits until the wheel stands there
  const FrameRecord* Next(const FrameRecord& planned) const;  // of the same role, still to take
  void Step(const std::string& what, const FrameRecord* frame);

  SessionFolder& folder_;
  Station& station_;
  const CaptureOptions& options_;
  CaptureSummary& summary_;
  LightMemory light_;
  std::optional<FrameRole> placed_;
  std::future<void> move_;
  int moving_to_ = 0, stands_at_ = 0;
  std::optional<Clock::time_point> flash_ready_;
  double wheel_s_ = 0.0;  // of the last move
};

}  // namespace dermap
