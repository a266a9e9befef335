// SPDX-License-Identifier: Apache-2.0
// The folder of a session while it is taken: which frames are safe, and how one becomes so.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acquire/devices/camera.h"
#include "common/files/session.h"
#include "common/files/session_journal.h"

namespace dermap {

// "2025-06-01T09:30:00.123Z"
std::string NowUtc();
// "frame 7 (skin, 450 nm)"
std::string DescribeFrame(const FrameRecord& frame);

class SessionFolder {
 public:
  // Begins a session in a folder that is new or empty, or goes on with one (`resume`): what its journal tells
  // of and whose file is as it was written is kept. `session` brings directory, version, rig and plan. Throws
  // InputError where there is something in the way, nothing to resume, or a journal of another plan, rig or
  // scene.
  SessionFolder(Session session, std::vector<FrameRecord> schedule, const std::string& fingerprint,
                bool resume);

  const Session& session() const { return session_; }
  const std::vector<FrameRecord>& schedule() const { return schedule_; }
  int total() const { return static_cast<int>(schedule_.size()); }
  int done() const { return static_cast<int>(session_.frames.size()); }
  bool Has(const FrameRecord& planned) const;

  // Takes the filter at another ISO from here on: journal, schedule and manifest. Frames that were taken at
  // the old one count no more.
  void ChangeExposure(ExposureChange change);
  int ChangesOf(const FrameRecord& frame) const;  // so far, of its filter and role
  // Adds to the schedule the black frames that frames at changed exposures lack; false where none do.
  bool AddMissingBlackFrames();

  // The number of a frame that is there with the same bytes; 0 where none is.
  int NumberOfCopy(const std::string& sha256) const;

  // Writes the file, then the journal's line, then the manifest. Returns the record with file and hash. A
  // frame that is there already is replaced.
  FrameRecord Add(const FrameRecord& planned, const RawFrame& raw, const std::string& time_utc);
  // A frame that is there but is not what it should be: it is missing from here on.
  void Withdraw(int number, const std::string& why);
  // A line for whoever looks for the cause of a failure.
  void Note(nlohmann::json event);
  // Marks the session complete where it is, and writes the manifest.
  void Close();

 private:
  void Restore(const std::string& fingerprint);
  void KeepFramesOf(const std::vector<nlohmann::json>& events);
  void KeepFrame(FrameRecord frame, const std::string& journal);
  void Apply(const ExposureChange& change);
  void DropDamaged();
  void RemoveLeftovers() const;

  Session session_;
  std::vector<FrameRecord> schedule_;
  std::optional<Journal> journal_;
  bool ended_ = false;  // the journal says already that the session is complete
};

}  // namespace dermap
