// SPDX-License-Identifier: Apache-2.0
// Opening a session folder for a plan and a rig, and running what it lacks.
#include "acquire/sequence.h"

#include <chrono>
#include <system_error>

#include "acquire/reference_session.h"
#include "acquire/schedule.h"
#include "acquire/session_folder.h"
#include "acquire/session_runner.h"
#include "common/core/error.h"
#include "common/core/version.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

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
  if (options.subject) {
    session.plan.subject = options.subject->subject;
    session.plan.site = options.subject->site;
    session.plan.notes = options.subject->notes;
  }
  std::vector<FrameRecord> schedule = MakeSchedule(rig, session.plan);
  const std::string fingerprint = Fingerprint(rig, schedule);
  return SessionFolder(std::move(session), std::move(schedule), fingerprint, options.resume);
}

}  // namespace

CaptureSummary RunCapture(const CaptureOptions& options) {
  const std::unique_ptr<Station> station = MakeStation(RigOf(options), options.ask);
  return RunCapture(options, *station);
}

CaptureSummary RunCapture(const CaptureOptions& options, Station& station) {
  const auto start = std::chrono::steady_clock::now();
  const RigConfig rig = RigOf(options);
  // One that cannot be used is told of before anything is begun.
  if (!options.reference.empty()) ReferenceSession(options.reference, rig);
  SessionFolder folder = OpenSession(options, rig);
  folder.AddMissingBlackFrames();  // one may have ended between the last changed frame and its black ones
  CaptureSummary summary;
  summary.kept = folder.done();
  if (folder.done() < folder.total() || options.retake)
    SessionRunner(folder, station, options, summary).Run();
  folder.Close();
  summary.total = folder.total();
  summary.session = folder.session();
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return summary;
}

}  // namespace dermap
