// SPDX-License-Identifier: Apache-2.0
// The order of things, and what is done when one fails.
#include "acquire/session_runner.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <tuple>

#include "acquire/devices/device_fault.h"
#include "acquire/frame_warning.h"
#include "acquire/preflight.h"
#include "acquire/reference_session.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr int kAttempts = 3;     // to get a good frame
constexpr int kMostChanges = 4;  // of one filter's exposure
constexpr double kPreparation =
    0.5;  // share of the progress that making the devices takes: rendering the scene
constexpr double kOldReference_h = 24.0;

int ChangesOf(const Session& session, const FrameRecord& f) {
  return static_cast<int>(std::count_if(session.exposure_changes.begin(), session.exposure_changes.end(),
                                        [&](const auto& c) { return c.slot == f.slot && c.role == f.role; }));
}

}  // namespace

SessionRunner::SessionRunner(SessionFolder& folder, Station& station, const CaptureOptions& options,
                             CaptureSummary& summary)
    : folder_(folder), station_(station), options_(options), summary_(summary) {}

SessionRunner::~SessionRunner() {
  if (move_.valid()) move_.wait();
}

double SessionRunner::Now() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void SessionRunner::Step(const std::string& what, const FrameRecord* frame) {
  if (options_.on_step) options_.on_step(what, frame);
}

void SessionRunner::Warn(const std::string& warning) {
  if (!warning.empty()) summary_.warnings.push_back(warning);
}

void SessionRunner::TellOfSchedule(const std::string& why) {
  if (options_.on_schedule) options_.on_schedule(folder_.schedule(), why);
}

const FrameRecord& SessionRunner::Planned(int number) const {
  return folder_.schedule()[static_cast<std::size_t>(number) - 1];
}

bool SessionRunner::AskWhileTimeStands(const OperatorRequest& request) {
  TimeSpan wait{Now(), 0.0};
  const bool done = options_.ask(request);
  wait.end_s = Now();
  summary_.timeline.waits.push_back(wait);
  return done;
}

bool SessionRunner::ShallStop() {
  return options_.stop && options_.stop();
}

void SessionRunner::Preflight() {
  Step("connect", nullptr);
  station_.Prepare([&](double fraction) {
    if (options_.progress) options_.progress(kPreparation * fraction);
  });
  Step("check", nullptr);
  CheckBeforeFirstFrame(folder_, station_);
  station_.WriteRecords(folder_.session().directory, folder_.schedule());
}

// What is there already tells what light each slot gives.
void SessionRunner::LearnFromWhatIsThere() {
  const Session& session = folder_.session();
  for (const FrameRecord& f : session.frames) {
    if (f.role != FrameRole::kSpectralon) continue;
    const RawFrame raw{ReadBinaryFile(session.directory / f.file),
                       std::filesystem::path(f.file).extension().string()};
    const FrameCheck check = CheckFrame(raw, session.rig.gray_card_region);
    if (check.decodes) light_.Learn(f, check);
  }
}

void SessionRunner::TakeFromReference() {
  if (options_.reference.empty()) return;
  ReferenceSession reference(options_.reference, folder_.session().rig);
  if (reference.age_h() > kOldReference_h) {
    Warn("the reference session " + options_.reference.string() + " is " +
         std::to_string(std::lround(reference.age_h())) +
         " hours old; the gray card tells its drift, but not what else has changed");
  }
  folder_.Note(
      {{"event", "reference"}, {"session", options_.reference.string()}, {"age_h", reference.age_h()}});
  // Its Spectralon was taken as its own plan was changed.
  const auto& made = folder_.session().exposure_changes;
  for (const ExposureChange& change : reference.exposure_changes()) {
    const bool known =
        std::any_of(made.begin(), made.end(), [&](const auto& m) { return m.why == change.why; });
    if (change.role == FrameRole::kSpectralon && !known) folder_.ChangeExposure(change);
  }
  for (const FrameRole role : {FrameRole::kSpectralon, FrameRole::kBlack}) {
    folder_.AddMissingBlackFrames();
    for (const FrameRecord& planned : folder_.schedule()) {
      if (planned.role != role || folder_.Has(planned)) continue;
      const FrameRecord source = reference.Find(planned);
      folder_.Add(planned, reference.Read(source), source.time_utc);
      ++summary_.from_reference;
    }
  }
}

void SessionRunner::Run() {
  TakeFromReference();
  TellOfSchedule("");
  LearnFromWhatIsThere();
  if (folder_.done() < folder_.total()) Preflight();
  while (true) {
    if (!Retake()) return;
    const FrameRecord* next = NextMissing();
    // With the target in place done, black frames for what was changed follow, before the next one is asked
    // for.
    if ((next == nullptr || next->role != placed_) && folder_.AddMissingBlackFrames()) {
      TellOfSchedule("");
      next = NextMissing();
    }
    if (next == nullptr) break;
    if (ShallStop()) return;
    StartMove(next->slot);  // while the operator is busy
    if (!Place(next->role) || !TakePatiently(next->number)) return;
  }
  if (schedule_changed_) station_.WriteRecords(folder_.session().directory, folder_.schedule());
}

bool SessionRunner::Retake() {
  if (!options_.retake) return true;
  for (auto number = options_.retake(); number; number = options_.retake()) {
    if (*number < 1 || *number > folder_.total()) continue;
    if (!Place(Planned(*number).role) || !TakePatiently(*number)) return false;
  }
  return true;
}

bool SessionRunner::Place(FrameRole role) {
  // The opaque slot hides whatever is in place.
  if (placed_ == role || (placed_ && role == FrameRole::kBlack)) return true;
  if (station_.NeedsOperator()) {
    Step("place", nullptr);
    if (options_.ask && !AskWhileTimeStands(PlaceRequest(role))) return false;
  }
  station_.Place(role);
  placed_ = role;
  return true;
}

bool SessionRunner::TakePatiently(int number) {
  while (true) {
    try {
      Take(number);
      return true;
    } catch (const DeviceError& error) {
      if (move_.valid()) move_.wait();
      move_ = {};
      moving_to_ = stands_at_ = 0;
      const auto* fault = dynamic_cast<const DeviceFault*>(&error);
      folder_.Note({{"event", "paused"},
                    {"number", number},
                    {"fault", fault != nullptr ? FaultName(fault->kind()) : "no good frame"},
                    {"problem", error.what()}});
      Step("paused", &Planned(number));
      OperatorRequest request;
      request.kind = OperatorRequest::Kind::kFault;
      request.sentence = error.what();
      if (!options_.ask || !station_.NeedsOperator() || !AskWhileTimeStands(request)) throw;
      folder_.Note({{"event", "unpaused"}, {"number", number}});
      station_.wheel().Home();
    }
  }
}

void SessionRunner::Take(int number) {
  Attempt result;
  underexposed_ = 0;
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    const FrameRecord planned = Planned(number);  // a copy: its exposure may change
    result = TryOnce(planned, attempt == kAttempts);
    if (result.exposure_changed) attempt = 0;
    if (result.exposure_changed) continue;
    if (result.problem.empty()) return;
    spdlog::warn("{} {}; attempt {} of {}", DescribeFrame(planned), result.problem, attempt, kAttempts);
    folder_.Note({{"event", "frame_rejected"}, {"number", number}, {"problem", result.problem}});
  }
  throw DeviceError(station_.camera().Name() + ": " + DescribeFrame(Planned(number)) + " " + result.problem +
                    " (" + std::to_string(kAttempts) +
                    " attempts); remedy: check camera, wheel and flash, then go on with --resume");
}

std::string SessionRunner::Expose(const FrameRecord& planned, FrameTiming& timing) {
  const CaptureSettings settings{planned.exposure_ms, planned.iso, planned.number};
  Step("move", &planned);
  timing.ready.start_s = Now();
  station_.camera().MakeReady(settings);  // while the wheel turns and the flash recycles
  timing.ready.end_s = Now();
  FinishMove(planned.slot);
  timing.wheel = wheel_span_;
  wheel_span_ = {};
  // It takes the camera a while to press; the quickest press so far is what may be counted on.
  if (flash_ready_)
    std::this_thread::sleep_until(*flash_ready_ - quickest_press_.value_or(Clock::duration{}));
  Step("expose", &planned);
  timing.expose.start_s = Now();
  const Clock::time_point start = Clock::now();
  const Clock::time_point pressed = station_.camera().Expose(settings);
  timing.expose.end_s = Now();
  quickest_press_ = std::min(quickest_press_.value_or(pressed - start), pressed - start);
  const double recycle_s = folder_.session().rig.flash_recycle_s;
  timing.flash.start_s = std::chrono::duration<double>(pressed - start_).count();
  timing.flash.end_s = timing.flash.start_s + recycle_s;
  // From press to flash is the same time for every frame.
  flash_ready_ =
      pressed + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(recycle_s));
  return NowUtc();
}

SessionRunner::Attempt SessionRunner::TryOnce(const FrameRecord& planned, bool last_attempt) {
  summary_.timeline.frames.push_back({});
  FrameTiming& timing = summary_.timeline.frames.back();
  timing.number = planned.number;
  const std::string time_utc = Expose(planned, timing);
  if (const FrameRecord* next = NextMissing(planned.number)) {
    if (next->role == placed_ || next->role == FrameRole::kBlack) StartMove(next->slot);
  }
  Step("fetch", &planned);
  timing.fetch.start_s = Now();
  RawFrame raw;
  try {
    raw = station_.camera().Fetch();
  } catch (const DeviceFault&) {
    throw;  // it lasts
  } catch (const DeviceError& lost) {
    timing.fetch.end_s = Now();
    return {std::string("was lost: ") + lost.what()};
  }
  timing.fetch.end_s = timing.check.start_s = Now();
  const RigConfig& rig = folder_.session().rig;
  const FrameCheck check = CheckFrame(raw, rig.gray_card_region);
  LightJudgement light;
  const std::string problem = Verify(planned, raw, check, light, last_attempt);
  timing.check.end_s = timing.write.start_s = timing.write.end_s = Now();
  if (!problem.empty()) {
    // Which filter it went through is not sure any more.
    if (light.problem == LightProblem::kOtherSlot || light.problem == LightProblem::kNotBlack) HomeWheel();
    return {problem};
  }
  if (light.problem == LightProblem::kNone && folder_.session().plan.adapt_exposure) {
    const Attempt adapted =
        Adapt(planned, AdviseExposure(planned, check, rig.gray_card_reflectance), last_attempt);
    if (adapted.exposure_changed || !adapted.problem.empty()) return adapted;
  }
  timing.good = true;
  Keep(planned, raw, check, light, time_utc);
  return {};
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

// A frame too dark may be one weak flash: only a second one is believed. A frame too bright is not to be had
// from one.
SessionRunner::Attempt SessionRunner::Adapt(const FrameRecord& planned, const ExposureAdvice& advice,
                                            bool last_attempt) {
  if (advice.problem == ExposureProblem::kNone || ChangesOf(folder_.session(), planned) >= kMostChanges)
    return {};
  if (advice.problem == ExposureProblem::kUnderexposed && underexposed_ != planned.number) {
    underexposed_ = planned.number;
    if (last_attempt) return {};
    return {"seems underexposed: " + advice.why + "; taken once more to be sure"};
  }
  const auto iso = IsoThatCameraTakes(planned, advice.isos);
  if (!iso) return {};
  const std::string why = DescribeFrame(planned) + ": " + advice.why;
  folder_.ChangeExposure({planned.role, planned.slot, planned.iso, *iso, planned.number, why, ""});
  schedule_changed_ = true;
  const std::string notice = why + "; slot " + std::to_string(planned.slot) + " is taken at ISO " +
                             std::to_string(*iso) + " in place of " + std::to_string(planned.iso);
  spdlog::warn("{}", notice);
  Warn(notice);
  TellOfSchedule(notice);
  return {"", true};
}

std::optional<int> SessionRunner::IsoThatCameraTakes(const FrameRecord& planned,
                                                     const std::vector<int>& isos) {
  for (const int iso : isos) {
    try {
      station_.camera().Check({planned.exposure_ms, iso, planned.number});
      return iso;
    } catch (const DeviceFault& fault) {
      if (fault.kind() != FaultKind::kSettings) throw;
    }
  }
  return std::nullopt;
}

void SessionRunner::Keep(const FrameRecord& planned, const RawFrame& raw, const FrameCheck& check,
                         const LightJudgement& light, const std::string& time_utc) {
  FrameEvent event;
  event.frame = folder_.Add(planned, raw, time_utc);
  FrameTiming& timing = summary_.timeline.frames.back();
  timing.write.end_s = Now();
  event.timing = timing;
  if (light.problem == LightProblem::kNone) light_.Learn(planned, check);
  event.check = check;
  event.drift = light.drift;
  event.done = folder_.done();
  event.total = folder_.total();
  event.warning = WarningAbout(planned, check, light, folder_.session().rig.gray_card_reflectance);
  Warn(event.warning);
  ++summary_.taken;
  progress_ = std::max(progress_, kPreparation + (1.0 - kPreparation) * event.done / event.total);
  if (options_.progress) options_.progress(progress_);
  if (options_.on_frame) options_.on_frame(event, raw);
}

const FrameRecord* SessionRunner::NextMissing(int besides) const {
  const auto rank = [&](const FrameRecord& f) { return std::tuple(f.role != placed_, f.role, f.number); };
  const FrameRecord* next = nullptr;
  for (const FrameRecord& f : folder_.schedule()) {
    if (f.number == besides || folder_.Has(f)) continue;
    if (next == nullptr || rank(f) < rank(*next)) next = &f;
  }
  return next;
}

void SessionRunner::StartMove(int slot) {
  if (move_.valid() || slot == stands_at_ || !station_.wheel().MovesByItself()) return;
  moving_to_ = slot;
  stands_at_ = 0;
  move_ = std::async(std::launch::async, [this, slot] {
    wheel_span_.start_s = Now();
    station_.wheel().MoveTo(slot);
    wheel_span_.end_s = Now();
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
  wheel_span_.start_s = Now();
  stands_at_ = 0;
  station_.wheel().MoveTo(slot);
  wheel_span_.end_s = Now();
  stands_at_ = slot;
}

void SessionRunner::HomeWheel() {
  if (move_.valid()) move_.get();
  station_.wheel().Home();
  moving_to_ = stands_at_ = 0;
}

}  // namespace dermap
