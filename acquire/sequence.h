// SPDX-License-Identifier: Apache-2.0
// One capture session, from a plan and a rig to a session folder. A frame counts once its file is on disk and
// its line in the journal; whatever stops a session in between, resuming takes what is missing, and nothing
// twice.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "acquire/devices/station.h"
#include "acquire/frame_check.h"
#include "common/core/progress.h"
#include "common/files/session.h"

namespace dermap {

struct FrameEvent {
  FrameRecord frame;
  FrameCheck check;
  int done = 0;  // frames of the session that are safe, this one included
  int total = 0;
  std::string warning;  // about its exposure; empty where it is fine
};

struct CaptureOptions {
  std::filesystem::path plan;
  std::filesystem::path rig;
  std::filesystem::path out;
  bool resume = false;
  std::filesystem::path scene;  // for simulated devices: instead of the rig's scene
  ProgressFunction progress;
  std::function<void(FrameRole)> place;  // asks the operator for the target; returns once it is there
  std::function<void(const FrameEvent&)> on_frame;  // after each frame that is safe
  std::function<bool()> stop;  // asked before each frame; true ends the session, to be resumed
};

struct CaptureSummary {
  Session session;  // complete or not
  int taken = 0;    // frames exposed by this run
  int kept = 0;     // frames that an interrupted run had left
  int total = 0;    // frames of the plan
  double seconds = 0.0;
  std::vector<std::string> warnings;
};

// Throws InputError (plan and rig that do not fit, a folder that holds a session already, nothing to resume),
// DeviceError and StorageError; after the last two the session can be resumed.
CaptureSummary RunCapture(const CaptureOptions& options);
// The same with devices that are there already (the daemon's, or a test's).
CaptureSummary RunCapture(const CaptureOptions& options, Station& station);

}  // namespace dermap
