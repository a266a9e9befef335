// SPDX-License-Identifier: Apache-2.0
// The order is what makes it safe: a frame's file is whole before the journal tells of it, and the journal is
// on disk before the next frame. The manifest can be made anew from the journal at any time.
#include "acquire/session_folder.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>

#include "acquire/schedule.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void CheckFolder(const fs::path& out, bool resume) {
  std::error_code error;
  const bool begun = fs::exists(out / "journal.jsonl", error) || fs::exists(out / "session.json", error);
  if (resume && !begun) {
    throw InputError("there is no session to resume in " + out.string() +
                     "; remedy: leave out --resume to begin one");
  }
  if (!resume && begun) {
    throw InputError(out.string() +
                     " already holds a session; remedy: name another folder, or go on with it by --resume");
  }
  if (begun || !fs::exists(out, error)) return;
  if (!fs::is_directory(out, error) || !fs::is_empty(out, error)) {
    throw InputError(out.string() + " is not an empty folder; remedy: name a new one for the session");
  }
}

std::string KindOf(const json& event) {
  return event.value("event", "");
}

}  // namespace

std::string NowUtc() {
  const auto now = std::chrono::system_clock::now();
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  const auto since_epoch = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch());
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char date[32], text[48];
  std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &utc);
  std::snprintf(text, sizeof text, "%s.%03dZ", date, static_cast<int>(since_epoch.count() % 1000));
  return text;
}

std::string DescribeFrame(const FrameRecord& f) {
  std::string text = "frame " + std::to_string(f.number) + " (" + std::string(RoleName(f.role));
  if (f.role != FrameRole::kBlack) text += ", " + std::to_string(std::lround(f.wavelength_nm)) + " nm";
  return text + ")";
}

SessionFolder::SessionFolder(Session session, std::vector<FrameRecord> schedule,
                             const std::string& fingerprint, bool resume)
    : session_(std::move(session)), schedule_(std::move(schedule)) {
  CheckFolder(session_.directory, resume);
  journal_.emplace(session_.directory / "journal.jsonl");
  Restore(fingerprint);
}

void SessionFolder::Restore(const std::string& fingerprint) {
  const fs::path path = session_.directory / "journal.jsonl";
  const std::vector<json> events = ReadJournal(path);
  if (events.empty()) {
    session_.started_utc = NowUtc();
    journal_->Append({{"event", "session_started"},
                      {"time_utc", session_.started_utc},
                      {"dermap_version", session_.dermap_version},
                      {"fingerprint", fingerprint},
                      {"frames", total()}});
    return;
  }
  if (KindOf(events[0]) != "session_started" || events[0].value("fingerprint", "") != fingerprint) {
    throw InputError(path.string() +
                     " was begun with another plan, rig or scene; remedy: resume with the same ones, or "
                     "begin a new session in another folder");
  }
  session_.started_utc = events[0].value("time_utc", "");
  KeepFramesOf(events);
  RemoveLeftovers();
  if (done() < total())
    journal_->Append({{"event", "session_resumed"}, {"time_utc", NowUtc()}, {"kept", done()}});
}

void SessionFolder::KeepFrame(FrameRecord frame, const std::string& journal) {
  const auto place = static_cast<std::size_t>(frame.number) - 1;
  if (place >= schedule_.size() || !SamePlace(frame, schedule_[place])) {
    throw InputError(journal + ": " + DescribeFrame(frame) +
                     " is not in the plan; remedy: restore the journal from a copy");
  }
  auto& frames = session_.frames;
  std::erase_if(frames,
                [&](const FrameRecord& f) { return f.number == frame.number; });  // the last one counts
  frames.push_back(std::move(frame));
}

// The schedule as it was changed, and the frames that were taken by it.
void SessionFolder::KeepFramesOf(const std::vector<json>& events) {
  const std::string journal = (session_.directory / "journal.jsonl").string();
  for (const json& event : events) {
    const std::string kind = KindOf(event);
    ended_ = kind == "session_complete";
    if (kind == "frame" && event.contains("frame"))
      KeepFrame(FrameFromJson(event["frame"], journal), journal);
    if (kind == "frame_withdrawn") {
      std::erase_if(session_.frames,
                    [&](const FrameRecord& f) { return f.number == event.value("number", 0); });
    }
    if (kind == "exposure_changed")
      Apply(ExposureChangeFromJson(event.value("change", json::object()), journal));
    if (kind == "black_frames_added") {
      AddBlackFrames({event.value("exposure_ms", 0.0), event.value("iso", 0)}, session_.plan.black_frames,
                     session_.rig, schedule_);
    }
  }
  DropDamaged();
}

void SessionFolder::DropDamaged() {
  auto& frames = session_.frames;
  std::erase_if(frames, [&](const FrameRecord& f) {
    std::error_code error;
    const fs::path file = session_.directory / f.file;
    if (fs::is_regular_file(file, error) && Sha256OfFile(file) == f.sha256) return false;
    spdlog::warn("{} is missing or damaged and will be taken again", file.string());
    return true;
  });
  std::sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
}

// Files under the name of a scheduled frame that no record speaks of: what was being written when we were
// killed, or the first file of a frame that was taken again. What else lies there is not ours.
void SessionFolder::RemoveLeftovers() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(session_.directory / "frames", error)) {
    const std::string name = entry.path().filename().string();
    const bool is_kept = std::any_of(session_.frames.begin(), session_.frames.end(),
                                     [&](const auto& f) { return fs::path(f.file).filename() == name; });
    const bool is_ours = std::any_of(schedule_.begin(), schedule_.end(), [&](const FrameRecord& f) {
      const std::string stem = fs::path(FrameFileName(f, "x")).stem().string();
      return entry.path().stem() == stem || name.starts_with("." + stem + ".partial-");
    });
    if (is_ours && !is_kept) fs::remove(entry.path(), error);
  }
}

void SessionFolder::Apply(const ExposureChange& change) {
  ApplyExposureChange(change, schedule_);
  std::erase_if(session_.frames, [&](const FrameRecord& f) {
    return !SamePlace(f, schedule_[static_cast<std::size_t>(f.number) - 1]);
  });
  session_.exposure_changes.push_back(change);
}

void SessionFolder::ChangeExposure(ExposureChange change) {
  change.time_utc = NowUtc();
  journal_->Append({{"event", "exposure_changed"}, {"change", ExposureChangeToJson(change)}});
  Apply(change);
  WriteSession(session_);
}

int SessionFolder::ChangesOf(const FrameRecord& f) const {
  const auto& changes = session_.exposure_changes;
  return static_cast<int>(std::count_if(changes.begin(), changes.end(),
                                        [&](const auto& c) { return c.slot == f.slot && c.role == f.role; }));
}

bool SessionFolder::AddMissingBlackFrames() {
  if (session_.plan.black_frames == 0) return false;
  const auto lacking = SettingsWithoutBlack(session_.frames, schedule_);
  for (const ExposureSetting& setting : lacking) {
    Note({{"event", "black_frames_added"}, {"exposure_ms", setting.exposure_ms}, {"iso", setting.iso}});
    AddBlackFrames(setting, session_.plan.black_frames, session_.rig, schedule_);
  }
  return !lacking.empty();
}

bool SessionFolder::Has(const FrameRecord& planned) const {
  return std::any_of(session_.frames.begin(), session_.frames.end(),
                     [&](const FrameRecord& f) { return f.number == planned.number; });
}

int SessionFolder::NumberOfCopy(const std::string& sha256) const {
  const auto found = std::find_if(session_.frames.begin(), session_.frames.end(),
                                  [&](const FrameRecord& f) { return f.sha256 == sha256; });
  return found == session_.frames.end() ? 0 : found->number;
}

FrameRecord SessionFolder::Add(const FrameRecord& planned, const RawFrame& raw, const std::string& time_utc) {
  FrameRecord frame = planned;
  frame.time_utc = time_utc;
  frame.file = FrameFileName(frame, raw.extension);
  frame.sha256 = Sha256(raw.bytes);
  WriteFileAtomically(session_.directory / frame.file, std::span<const std::byte>(raw.bytes));
  journal_->Append({{"event", "frame"}, {"frame", FrameToJson(frame)}});  // from here on the frame is safe
  auto& frames = session_.frames;
  std::string before;  // a camera may name its files otherwise than the last time
  for (const FrameRecord& f : frames) {
    if (f.number == frame.number) before = f.file;
  }
  std::erase_if(frames, [&](const FrameRecord& f) { return f.number == frame.number; });
  frames.insert(
      std::find_if(frames.begin(), frames.end(), [&](const auto& f) { return f.number > frame.number; }),
      frame);
  ended_ = false;
  WriteSession(session_);
  if (!before.empty() && before != frame.file) RemoveLeftovers();
  return frame;
}

void SessionFolder::Withdraw(int number, const std::string& why) {
  Note({{"event", "frame_withdrawn"}, {"number", number}, {"problem", why}});
  std::erase_if(session_.frames, [&](const FrameRecord& f) { return f.number == number; });
  ended_ = false;
  WriteSession(session_);
  RemoveLeftovers();
}

void SessionFolder::Note(json event) {
  event["time_utc"] = NowUtc();
  journal_->Append(event);
}

void SessionFolder::Close() {
  session_.complete = done() == total();
  if (session_.complete && !ended_) Note({{"event", "session_complete"}});
  WriteSession(session_);
}

}  // namespace dermap
