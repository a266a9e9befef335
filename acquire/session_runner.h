// SPDX-License-Identifier: Apache-2.0
// Takes what a session folder lacks, frame by frame, in an order that asks for each target once; pauses for
// faults that last. How one frame is taken is frame_taker.h.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "acquire/frame_taker.h"
#include "acquire/sequence.h"
#include "acquire/session_folder.h"
#include "common/core/error.h"

namespace dermap {

class SessionRunner {
 public:
  SessionRunner(SessionFolder& folder, Station& station, const CaptureOptions& options,
                CaptureSummary& summary);
  void Run();

 private:
  void Preflight();
  void GetReadyForFirstFrame();
  void PreflightPatiently();  // as often as the operator sees to what stands in its way
  void TakeFromReference();
  void TakeWhatIsMissing();
  bool Retake();                         // what was asked to be taken again; false: the session shall end
  bool Place(const FrameRecord& next);   // what it shows; false: the session shall end
  bool StandsFor(FrameRole role) const;  // what is in place does for it
  // Runs a step with that frame. At a fault that lasts it has the operator see to it, and returns with the
  // frame still missing; throws it on where nobody does.
  void Patiently(int number, const std::function<void()>& step);
  // Whether the operator has seen to a fault that lasts; `number` of the frame, 0 before the first.
  bool IsSeenTo(const DeviceError& error, int number);
  void Settle();  // the frame that is under way
  void SettleInSpiteOf(const DeviceError& fault);
  // What is still to take, the target in place first; never the frames with these numbers.
  const FrameRecord* NextMissing(int besides = 0, int besides_too = 0) const;
  int SlotAfter(const FrameRecord& planned) const;  // 0: nothing follows
  void TellOfSchedule();
  void Step(const std::string& what, const FrameRecord* frame);
  bool AskWhileTimeStands(const OperatorRequest& request);
  bool ShallStop();

  SessionFolder& folder_;
  Station& station_;
  const CaptureOptions& options_;
  CaptureSummary& summary_;
  const Stopwatch stopwatch_;
  FrameTaker taker_;
  std::optional<FrameRole> placed_;
  bool home_first_ = false;  // the wheel may have lost its place
};

}  // namespace dermap
