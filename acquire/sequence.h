// SPDX-License-Identifier: Apache-2.0
// One capture session, from a plan and a rig to a session folder. A frame counts once its file is on disk and
// its line in the journal; whatever stops a session in between, resuming takes what is missing, and nothing
// twice.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquire/devices/station.h"
#include "acquire/frame_check.h"
#include "acquire/timeline.h"
#include "common/core/progress.h"
#include "common/files/session.h"

namespace dermap {

struct FrameEvent {
  FrameRecord frame;
  FrameCheck check;
  FrameTiming timing;
  double drift = 0.0;  // of the gray card against this filter's first frame; 0 where unknown
  int done = 0;        // frames of the session that are safe, this one included
  int total = 0;
  std::string warning;  // about its exposure; empty where it is fine
};

// What an operator fills in for a session, in place of the plan's.
struct SubjectForm {
  std::string subject;  // a code, never a name
  std::string site;
  std::string notes;
};

struct CaptureOptions {
  std::filesystem::path plan;
  std::filesystem::path rig;
  std::filesystem::path out;
  bool resume = false;
  std::filesystem::path scene;      // for simulated devices: instead of the rig's scene
  std::filesystem::path reference;  // an earlier session whose black and Spectralon frames are taken over
  std::optional<SubjectForm> subject;
  ProgressFunction progress;
  AskOperator ask;  // of real devices: to place targets, and to see to faults that last
  // What is being done ("connect", "place", "move", "expose", "fetch", "paused"), for which frame (or
  // nullptr).
  std::function<void(const std::string&, const FrameRecord*)> on_step;
  std::function<void(const FrameEvent&, const RawFrame&)> on_frame;  // after each frame that is safe
  // All frames to take: at the beginning, and whenever an exposure was changed (then with the sentence why).
  std::function<void(const std::vector<FrameRecord>&, const std::string&)> on_schedule;
  std::function<bool()> stop;  // asked before each frame; true ends the session, to be resumed
  std::function<bool()>
      pauses;  // whether `stop` would wait now: what is under way is finished before it does
  std::function<std::optional<int>()> retake;  // asked before each frame: the number of one to take again
};

struct CaptureSummary {
  Session session;  // complete or not
  int taken = 0;    // frames exposed by this run
  int kept = 0;     // frames that an interrupted run had left
  int from_reference = 0;
  int total = 0;  // frames of the plan, and black ones for changed exposures
  double seconds = 0.0;
  std::vector<std::string> warnings;
  SessionTimeline timeline;
};

// Throws InputError (plan and rig that do not fit, a folder that holds a session already, nothing to resume),
// DeviceError and StorageError; after the last two the session can be resumed.
CaptureSummary RunCapture(const CaptureOptions& options);
// The same with devices that are there already (the daemon's, or a test's).
CaptureSummary RunCapture(const CaptureOptions& options, Station& station);

}  // namespace dermap
