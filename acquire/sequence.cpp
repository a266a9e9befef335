// SPDX-License-Identifier: Apache-2.0
// The session runner. For each frame: place the target, move the wheel, expose, decode, and hand it to the
// folder.
#include "acquire/sequence.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "acquire/schedule.h"
#include "acquire/session_folder.h"
#include "common/core/error.h"
#include "common/core/version.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

constexpr int kAttempts = 3;  // to get a frame that decodes
constexpr double kSaturatedShareToWarn = 0.001;
constexpr double kDarkLevel = 0.02;  // of the range: below it a lit frame is dark
constexpr double kBrightBlackLevel = 0.05;
constexpr double kSpareShare = 1.2;  // of disk space, the frames themselves being 1
constexpr double kPreparation =
    0.5;  // share of the progress that making the devices takes: rendering the scene

std::string WarningAbout(const FrameRecord& f, const FrameCheck& check) {
  if (f.role == FrameRole::kBlack) {
    return check.level > kBrightBlackLevel
               ? DescribeFrame(f) + " is not dark: light leaks past the opaque slot"
               : "";
  }
  if (check.saturated_share > kSaturatedShareToWarn) {
    char share[32];
    std::snprintf(share, sizeof share, "%.1f %%", 100.0 * check.saturated_share);
    return DescribeFrame(f) + ": " + share +
           " of the photosites are saturated; remedy: lower the ISO of slot " + std::to_string(f.slot) +
           " in the plan";
  }
  if (check.level < kDarkLevel)
    return DescribeFrame(f) + " is dark: the flash did not fire, or the ISO is far too low";
  return "";
}

void CheckSlots(const SessionFolder& folder, const FilterWheel& wheel) {
  for (const FrameRecord& f : folder.schedule()) {
    if (f.slot <= wheel.SlotCount()) continue;
    throw InputError("the plan needs slot " + std::to_string(f.slot) + ", but the " + wheel.Name() + " has " +
                     std::to_string(wheel.SlotCount()) + "; remedy: correct the slots of the rig");
  }
}

void CheckSpace(const SessionFolder& folder, const Camera& camera) {
  std::error_code error;
  const fs::path& out = folder.session().directory;
  const fs::space_info space = fs::space(out, error);
  const double needed =
      kSpareShare * static_cast<double>(camera.FrameBytes()) * (folder.total() - folder.done());
  if (error || static_cast<double>(space.available) >= needed) return;
  throw StorageError(out.string() + " has " + std::to_string(space.available / 1000000) +
                     " MB free, and the session needs " + std::to_string(std::lround(needed / 1e6)) +
                     " MB; remedy: free some space, then go on with --resume");
}

RawFrame Expose(SessionFolder& folder, Camera& camera, const FrameRecord& planned, FrameCheck& check) {
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    camera.Expose({planned.exposure_ms, planned.iso, planned.number});
    RawFrame raw = camera.Fetch();
    check = CheckFrame(raw);
    if (check.decodes) return raw;
    spdlog::warn("{} {}; attempt {} of {}", DescribeFrame(planned), check.problem, attempt, kAttempts);
    folder.Note({{"event", "frame_rejected"}, {"number", planned.number}, {"problem", check.problem}});
  }
  throw DeviceError(camera.Name() + ": " + DescribeFrame(planned) + " " + check.problem + " (" +
                    std::to_string(kAttempts) +
                    " attempts); remedy: check the camera's connection, then go on with --resume");
}

// Takes what the folder lacks.
void TakeFrames(SessionFolder& folder, Station& station, const CaptureOptions& options,
                CaptureSummary& summary) {
  CheckSlots(folder, station.wheel());
  CheckSpace(folder, station.camera());
  station.Prepare([&](double fraction) {
    if (options.progress) options.progress(kPreparation * fraction);
  });
  station.WriteRecords(folder.session().directory, folder.schedule());
  std::optional<FrameRole> placed;
  for (const FrameRecord& planned : folder.schedule()) {
    if (folder.Has(planned)) continue;
    if (options.stop && options.stop()) return;
    if (placed != planned.role) {
      if (options.place) options.place(planned.role);
      station.Place(planned.role);
      placed = planned.role;
    }
    station.wheel().MoveTo(planned.slot);
    FrameEvent event;
    const RawFrame raw = Expose(folder, station.camera(), planned, event.check);
    event.frame = folder.Add(planned, raw);
    event.done = folder.done();
    event.total = folder.total();
    event.warning = WarningAbout(planned, event.check);
    if (!event.warning.empty()) summary.warnings.push_back(event.warning);
    ++summary.taken;
    if (options.progress) options.progress(kPreparation + (1.0 - kPreparation) * event.done / event.total);
    if (options.on_frame) options.on_frame(event);
  }
}

RigConfig RigOf(const CaptureOptions& options) {
  RigConfig rig = ReadRig(options.rig);
  if (options.scene.empty()) return rig;
  std::error_code error;
  const fs::path shared = ConfigDirectory() / options.scene;
  if (fs::is_regular_file(options.scene, error)) {
    rig.simulated_scene = fs::absolute(options.scene).lexically_normal();
  } else if (fs::is_regular_file(shared, error)) {
    rig.simulated_scene = shared;
  } else {
    throw InputError("the scene " + options.scene.string() + " does not exist, neither as named nor at " +
                     shared.string() + "; remedy: correct --scene");
  }
  return rig;
}

SessionFolder OpenSession(const CaptureOptions& options, const RigConfig& rig) {
  Session session;
  session.directory = options.out;
  session.dermap_version = kVersion;
  session.rig = rig;
  session.plan = ReadPlan(options.plan);
  std::vector<FrameRecord> schedule = MakeSchedule(rig, session.plan);
  const std::string fingerprint = Fingerprint(rig, schedule);
  return SessionFolder(std::move(session), std::move(schedule), fingerprint, options.resume);
}

}  // namespace

CaptureSummary RunCapture(const CaptureOptions& options) {
  const std::unique_ptr<Station> station = MakeStation(RigOf(options));
  return RunCapture(options, *station);
}

CaptureSummary RunCapture(const CaptureOptions& options, Station& station) {
  const auto start = std::chrono::steady_clock::now();
  SessionFolder folder = OpenSession(options, RigOf(options));
  CaptureSummary summary;
  summary.total = folder.total();
  summary.kept = folder.done();
  if (summary.kept < summary.total) TakeFrames(folder, station, options, summary);
  folder.Close();
  summary.session = folder.session();
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return summary;
}

}  // namespace dermap
