// SPDX-License-Identifier: Apache-2.0
// The order of things, and what is done when one fails.
#include "acquire/session_runner.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>
#include <thread>

#include "acquire/devices/device_fault.h"
#include "acquire/reference_session.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

constexpr int kAttempts = 3;  // to get a good frame
constexpr double kSaturatedShareToWarn = 0.001;
constexpr double kDriftToWarn = 0.1;
constexpr double kSpareShare = 1.2;  // of disk space, the frames themselves being 1
constexpr double kPreparation =
    0.5;  // share of the progress that making the devices takes: rendering the scene
constexpr double kIsoTolerance = 0.02, kExposureTolerance = 0.2;  // of what a file says about itself
constexpr std::time_t kEarliestClock = 1704067200;                // 2024: a clock before it was never set
constexpr double kOldReference_h = 24.0;

std::string Percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100.0 * share);
  return text;
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string WarningAbout(const FrameRecord& f, const FrameCheck& check, const LightJudgement& light) {
  if (light.problem != LightProblem::kNone) return DescribeFrame(f) + " " + DescribeLight(light);
  if (f.role != FrameRole::kBlack && check.saturated_share > kSaturatedShareToWarn) {
    return DescribeFrame(f) + ": " + Percent(check.saturated_share) +
           " of the photosites are saturated; remedy: lower the ISO of slot " + std::to_string(f.slot) +
           " in the plan";
  }
  if (std::abs(light.drift) > kDriftToWarn) {
    return DescribeFrame(f) + ": the gray card is " + Percent(std::abs(light.drift)) +
           (light.drift > 0 ? " brighter" : " darker") + " than in this filter's first frame";
  }
  return "";
}

void CheckSlots(const SessionFolder& folder, const FilterWheel& wheel) {
  for (const FrameRecord& f : folder.schedule()) {
    if (f.slot <= wheel.SlotCount()) continue;
    throw InputError("the plan needs slot " + std::to_string(f.slot) + ", but the " + wheel.Name() + " has " +
                     std::to_string(wheel.SlotCount()) + "; remedy: correct the slots of the rig");
  }
}

void CheckSpace(const SessionFolder& folder, Camera& camera) {
  std::error_code error;
  const fs::path& out = folder.session().directory;
  const fs::space_info space = fs::space(out, error);
  const int missing = folder.total() - folder.done();
  const double needed = kSpareShare * static_cast<double>(camera.FrameBytes()) * missing;
  if (!error && static_cast<double>(space.available) < needed) {
    throw StorageError(out.string() + " has " + std::to_string(space.available / 1000000) +
                       " MB free, and the session needs " + std::to_string(std::lround(needed / 1e6)) +
                       " MB; remedy: free some space, then go on with --resume");
  }
  const auto room = camera.RoomForFrames();
  if (room && *room < missing) {
    throw DeviceFault(FaultKind::kFull, camera.Name() + ": its card takes " + std::to_string(*room) +
                                            " more frames, the session needs " + std::to_string(missing) +
                                            "; remedy: put an empty card into it");
  }
}

void CheckClock() {
  if (std::time(nullptr) >= kEarliestClock) return;
  throw InputError(
      "this machine's clock stands before 2024; remedy: set it, since sessions are told apart by time");
}

void CheckSettings(const SessionFolder& folder, Camera& camera) {
  std::vector<std::pair<double, int>> seen;
  for (const FrameRecord& f : folder.schedule()) {
    const std::pair<double, int> setting{f.exposure_ms, f.iso};
    if (folder.Has(f) || std::find(seen.begin(), seen.end(), setting) != seen.end()) continue;
    seen.push_back(setting);
    camera.Check({f.exposure_ms, f.iso, f.number});
  }
}

// What the file says about how it was taken; cameras that say nothing are believed.
std::string WrongSettings(const FrameRecord& planned, const FrameCheck& check) {
  if (check.iso > 0.0 && std::abs(check.iso / planned.iso - 1.0) > kIsoTolerance) {
    return "was taken at ISO " + std::to_string(std::lround(check.iso)) + " in place of " +
           std::to_string(planned.iso);
  }
  if (check.exposure_ms > 0.0 &&
      std::abs(check.exposure_ms / planned.exposure_ms - 1.0) > kExposureTolerance) {
    return "was exposed for " + std::to_string(check.exposure_ms) + " ms in place of " +
           std::to_string(planned.exposure_ms);
  }
  return "";
}

}  // namespace

SessionRunner::SessionRunner(SessionFolder& folder, Station& station, const CaptureOptions& options,
                             CaptureSummary& summary)
    : folder_(folder), station_(station), options_(options), summary_(summary) {}

SessionRunner::~SessionRunner() {
  if (move_.valid()) move_.wait();
}

void SessionRunner::Step(const std::string& what, const FrameRecord* frame) {
  if (options_.on_step) options_.on_step(what, frame);
}

void SessionRunner::Preflight() {
  Step("connect", nullptr);
  CheckClock();
  station_.Prepare([&](double fraction) {
    if (options_.progress) options_.progress(kPreparation * fraction);
  });
  Step("check", nullptr);
  CheckSlots(folder_, station_.wheel());
  CheckSpace(folder_, station_.camera());
  CheckSettings(folder_, station_.camera());
  station_.WriteRecords(folder_.session().directory, folder_.schedule());
}

void SessionRunner::LearnFrom(const FrameRecord& frame, const RawFrame& raw) {
  const FrameCheck check = CheckFrame(raw, folder_.session().rig.gray_card_region);
  if (check.decodes) light_.Learn(frame, check);
}

void SessionRunner::TakeFromReference() {
  if (options_.reference.empty()) return;
  ReferenceSession reference(options_.reference, folder_.session().rig);
  if (reference.age_h() > kOldReference_h) {
    summary_.warnings.push_back("the reference session " + options_.reference.string() + " is " +
                                std::to_string(std::lround(reference.age_h())) +
                                " hours old; the gray card tells its drift, but not what else has changed");
  }
  folder_.Note(
      {{"event", "reference"}, {"session", options_.reference.string()}, {"age_h", reference.age_h()}});
  for (const FrameRecord& planned : folder_.schedule()) {
    if (planned.role == FrameRole::kSkin || folder_.Has(planned)) continue;
    const FrameRecord source = reference.Find(planned);
    folder_.Add(planned, reference.Read(source), source.time_utc);
    ++summary_.from_reference;
  }
}

void SessionRunner::Run() {
  TakeFromReference();
  // What is there already tells what light each slot gives.
  for (const FrameRecord& f : folder_.session().frames) {
    if (f.role == FrameRole::kSpectralon) {
      LearnFrom(
          f, {ReadBinaryFile(folder_.session().directory / f.file), fs::path(f.file).extension().string()});
    }
  }
  if (folder_.done() < folder_.total()) Preflight();
  for (const FrameRecord& planned : folder_.schedule()) {
    if (!Retake()) return;
    if (folder_.Has(planned)) continue;
    if (options_.stop && options_.stop()) return;
    if (!Place(planned.role) || !TakePatiently(planned)) return;
  }
  Retake();
}

bool SessionRunner::Retake() {
  if (!options_.retake) return true;
  for (auto number = options_.retake(); number; number = options_.retake()) {
    if (*number < 1 || *number > folder_.total()) continue;
    const FrameRecord& again = folder_.schedule()[static_cast<std::size_t>(*number) - 1];
    if (!Place(again.role) || !TakePatiently(again)) return false;
  }
  return true;
}

bool SessionRunner::Place(FrameRole role) {
  if (placed_ == role) return true;
  if (station_.NeedsOperator()) {
    const OperatorRequest request = PlaceRequest(role);
    Step("place", nullptr);
    if (options_.ask && !options_.ask(request)) return false;
  }
  station_.Place(role);
  placed_ = role;
  return true;
}

bool SessionRunner::TakePatiently(const FrameRecord& planned) {
  while (true) {
    try {
      Take(planned);
      return true;
    } catch (const DeviceError& error) {
      if (move_.valid()) move_.wait();
      move_ = {};
      moving_to_ = stands_at_ = 0;
      const auto* fault = dynamic_cast<const DeviceFault*>(&error);
      folder_.Note({{"event", "paused"},
                    {"number", planned.number},
                    {"fault", fault != nullptr ? FaultName(fault->kind()) : "no good frame"},
                    {"problem", error.what()}});
      Step("paused", &planned);
      OperatorRequest request;
      request.kind = OperatorRequest::Kind::kFault;
      request.sentence = error.what();
      if (!options_.ask || !station_.NeedsOperator() || !options_.ask(request)) throw;
      folder_.Note({{"event", "unpaused"}, {"number", planned.number}});
      station_.wheel().Home();
    }
  }
}

void SessionRunner::Take(const FrameRecord& planned) {
  std::string problem;
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    problem = TryOnce(planned, attempt == kAttempts);
    if (problem.empty()) return;
    spdlog::warn("{} {}; attempt {} of {}", DescribeFrame(planned), problem, attempt, kAttempts);
    folder_.Note({{"event", "frame_rejected"}, {"number", planned.number}, {"problem", problem}});
  }
  throw DeviceError(station_.camera().Name() + ": " + DescribeFrame(planned) + " " + problem + " (" +
                    std::to_string(kAttempts) +
                    " attempts); remedy: check camera, wheel and flash, then go on with --resume");
}

std::string SessionRunner::TryOnce(const FrameRecord& planned, bool last_attempt) {
  FrameTiming timing;
  Step("move", &planned);
  FinishMove(planned.slot);
  timing.wheel_s = wheel_s_;
  if (flash_ready_) {
    const auto start = Clock::now();
    std::this_thread::sleep_until(*flash_ready_);
    timing.flash_s = SecondsSince(start);
  }
  Step("expose", &planned);
  auto start = Clock::now();
  station_.camera().Expose({planned.exposure_ms, planned.iso, planned.number});
  const std::string time_utc = NowUtc();
  timing.expose_s = SecondsSince(start);
  flash_ready_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                    std::chrono::duration<double>(folder_.session().rig.flash_recycle_s));
  if (const FrameRecord* next = Next(planned)) StartMove(next->slot);

  Step("fetch", &planned);
  start = Clock::now();
  RawFrame raw;
  try {
    raw = station_.camera().Fetch();
  } catch (const DeviceFault&) {
    throw;  // it lasts
  } catch (const DeviceError& lost) {
    return std::string("was lost: ") + lost.what();
  }
  timing.fetch_s = SecondsSince(start);
  start = Clock::now();
  const FrameCheck check = CheckFrame(raw, folder_.session().rig.gray_card_region);
  LightJudgement light;
  std::string problem = Verify(planned, raw, check, light, last_attempt);
  timing.check_s = SecondsSince(start);
  if (!problem.empty()) {
    // Which filter it went through is not sure any more.
    if (light.problem == LightProblem::kOtherSlot || light.problem == LightProblem::kNotBlack) {
      if (move_.valid()) move_.get();
      station_.wheel().Home();
      moving_to_ = stands_at_ = 0;
    }
    return problem;
  }
  Keep(planned, raw, check, light, timing, time_utc);
  return "";
}

std::string SessionRunner::Verify(const FrameRecord& planned, const RawFrame& raw, const FrameCheck& check,
                                  LightJudgement& light, bool last_attempt) {
  if (!check.decodes) return check.problem;
  if (const int copy = folder_.NumberOfCopy(Sha256(raw.bytes)); copy != 0 && copy != planned.number) {
    return "is the file of frame " + std::to_string(copy) + " once more";
  }
  if (const std::string wrong = WrongSettings(planned, check); !wrong.empty()) {
    station_.camera().Reconnect();  // libgphoto2 may believe in settings that somebody has changed by hand
    return wrong;
  }
  light = light_.Judge(planned, check);
  // A flash that stays dark and a drifting lamp are the operator's to judge: kept in the end, with a warning.
  // A frame of another filter never is.
  const bool tolerable = light.problem == LightProblem::kDark || light.problem == LightProblem::kBright;
  if (light.problem == LightProblem::kNone || (tolerable && last_attempt)) return "";
  return DescribeLight(light);
}

void SessionRunner::Keep(const FrameRecord& planned, const RawFrame& raw, const FrameCheck& check,
                         const LightJudgement& light, const FrameTiming& timing,
                         const std::string& time_utc) {
  FrameEvent event;
  const auto start = Clock::now();
  event.frame = folder_.Add(planned, raw, time_utc);
  event.timing = timing;
  event.timing.write_s = SecondsSince(start);
  if (light.problem == LightProblem::kNone) light_.Learn(planned, check);
  event.check = check;
  event.drift = light.drift;
  event.done = folder_.done();
  event.total = folder_.total();
  event.warning = WarningAbout(planned, check, light);
  if (!event.warning.empty()) summary_.warnings.push_back(event.warning);
  summary_.timeline.push_back(event.timing);
  ++summary_.taken;
  if (options_.progress) options_.progress(kPreparation + (1.0 - kPreparation) * event.done / event.total);
  if (options_.on_frame) options_.on_frame(event, raw);
}

const FrameRecord* SessionRunner::Next(const FrameRecord& planned) const {
  for (const FrameRecord& f : folder_.schedule()) {
    if (f.number > planned.number && !folder_.Has(f)) return f.role == planned.role ? &f : nullptr;
  }
  return nullptr;
}

void SessionRunner::StartMove(int slot) {
  if (move_.valid() || slot == stands_at_ || !station_.wheel().MovesByItself()) return;
  moving_to_ = slot;
  stands_at_ = 0;
  move_ = std::async(std::launch::async, [this, slot] {
    const auto start = Clock::now();
    station_.wheel().MoveTo(slot);
    wheel_s_ = SecondsSince(start);
  });
}

void SessionRunner::FinishMove(int slot) {
  if (move_.valid()) {
    std::future<void> move = std::move(move_);
    move_ = {};
    move.get();
    stands_at_ = moving_to_;
  }
  if (stands_at_ == slot) return;
  const auto start = Clock::now();
  stands_at_ = 0;
  station_.wheel().MoveTo(slot);
  wheel_s_ = SecondsSince(start);
  stands_at_ = slot;
}

}  // namespace dermap
