// SPDX-License-Identifier: Apache-2.0
// The order of things, and what is done when one fails.
#include "acquire/session_runner.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "acquire/devices/device_fault.h"
#include "acquire/preflight.h"
#include "acquire/reference_session.h"
#include "acquire/schedule.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kOldReference_h = 24.0;

}  // namespace

SessionRunner::SessionRunner(SessionFolder& folder, Station& station, const CaptureOptions& options,
                             CaptureSummary& summary)
    : folder_(folder),
      station_(station),
      options_(options),
      summary_(summary),
      taker_(folder, station, options, summary, stopwatch_) {}

void SessionRunner::Step(const std::string& what, const FrameRecord* frame) {
  if (options_.on_step) options_.on_step(what, frame);
}

void SessionRunner::TellOfSchedule() {
  if (options_.on_schedule) options_.on_schedule(folder_.schedule(), "");
}

bool SessionRunner::AskWhileTimeStands(const OperatorRequest& request) {
  TimeSpan wait{stopwatch_.Now(), 0.0};
  const bool done = options_.ask(request);
  wait.end_s = stopwatch_.Now();
  summary_.timeline.waits.push_back(wait);
  return done;
}

bool SessionRunner::ShallStop() {
  return options_.stop && options_.stop();
}

void SessionRunner::Preflight() {
  Step("connect", nullptr);
  station_.Prepare([&](double fraction) {
    if (options_.progress) options_.progress(kShareOfPreparation * fraction);
  });
  Step("check", nullptr);
  CheckBeforeFirstFrame(folder_, station_);
  station_.WriteRecords(folder_.session().directory, folder_.schedule());
  GetReadyForFirstFrame();
}

// The wheel's first move belongs to its homing: no frame waits for it.
void SessionRunner::GetReadyForFirstFrame() {
  const FrameRecord* first = NextMissing();
  if (first == nullptr || !station_.wheel().MovesByItself()) return;
  taker_.wheel().Start(first->slot);
  station_.camera().MakeReady({first->exposure_ms, first->iso, first->number});
  taker_.wheel().Finish(first->slot);
  taker_.wheel().TakeSpan();
}

void SessionRunner::PreflightPatiently() {
  while (true) {
    try {
      return Preflight();
    } catch (const DeviceError& error) {
      taker_.wheel().Forget();
      if (!IsSeenTo(error, 0)) throw;
    }
  }
}

void SessionRunner::TakeFromReference() {
  if (options_.reference.empty()) return;
  ReferenceSession reference(options_.reference, folder_.session().rig);
  if (reference.age_h() > kOldReference_h) {
    taker_.Warn("the reference session " + options_.reference.string() + " is " +
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
  TellOfSchedule();
  taker_.light().LearnFrom(folder_.session());
  if (folder_.done() < folder_.total()) PreflightPatiently();
  TakeWhatIsMissing();
  if (taker_.schedule_changed() && NextMissing() == nullptr)
    station_.WriteRecords(folder_.session().directory, folder_.schedule());
}

void SessionRunner::TakeWhatIsMissing() {
  while (Retake()) {
    const FrameRecord* next = NextMissing(taker_.under_way());
    const bool rests = next == nullptr || !StandsFor(next->role) || (options_.pauses && options_.pauses());
    if (taker_.under_way() != 0 && rests) {
      Settle();
      continue;
    }
    // With the target in place done, black frames for what was changed follow, before the next one is asked
    // for.
    if ((next == nullptr || !StandsFor(next->role)) && folder_.AddMissingBlackFrames()) {
      TellOfSchedule();
      next = NextMissing();
    }
    if (next == nullptr) return;
    if (ShallStop()) return Settle();
    const FrameRecord planned = *next;                     // a copy: its exposure may change
    if (!home_first_) taker_.wheel().Start(planned.slot);  // while the operator is busy
    if (!Place(planned)) return;
    Patiently(planned.number, [&] { taker_.Take(planned, SlotAfter(planned)); });
  }
}

bool SessionRunner::Retake() {
  if (!options_.retake) return true;
  for (auto number = options_.retake(); number; number = options_.retake()) {
    if (*number < 1 || *number > folder_.total()) continue;
    Settle();
    const auto planned = [&] { return folder_.schedule()[static_cast<std::size_t>(*number) - 1]; };
    if (!Place(planned())) return false;
    const int taken_before = summary_.taken;
    while (summary_.taken == taken_before) {
      Patiently(*number, [&] {
        taker_.Take(planned(), 0);
        taker_.Settle();
      });
    }
  }
  return true;
}

void SessionRunner::Settle() {
  if (const int number = taker_.under_way(); number != 0) Patiently(number, [&] { taker_.Settle(); });
}

// The opaque slot hides whatever is in place.
bool SessionRunner::StandsFor(FrameRole role) const {
  return placed_ == role || (placed_ && role == FrameRole::kBlack);
}

bool SessionRunner::Place(const FrameRecord& next) {
  if (StandsFor(next.role)) return true;
  if (station_.NeedsOperator()) {
    Step("place", nullptr);
    taker_.setter().Start({next.exposure_ms, next.iso, next.number});  // while the operator is busy
    if (options_.ask && !AskWhileTimeStands(PlaceRequest(next.role))) return false;
  }
  station_.Place(next.role);
  placed_ = next.role;
  return true;
}

void SessionRunner::Patiently(int number, const std::function<void()>& step) {
  try {
    if (home_first_) taker_.wheel().Home();
    home_first_ = false;
    step();
  } catch (const DeviceError& error) {
    taker_.wheel().Forget();
    SettleInSpiteOf(error);
    const auto* given_up = dynamic_cast<const FrameGivenUp*>(&error);
    const int failed = given_up != nullptr ? given_up->number() : number;
    if (!IsSeenTo(error, failed)) throw;
    taker_.doubts().StartOver(failed, given_up != nullptr);
    home_first_ = true;
  }
}

bool SessionRunner::IsSeenTo(const DeviceError& error, int number) {
  const auto* fault = dynamic_cast<const DeviceFault*>(&error);
  folder_.Note({{"event", "paused"},
                {"number", number},
                {"fault", fault != nullptr ? FaultName(fault->kind()) : "no good frame"},
                {"problem", error.what()}});
  std::optional<FrameRecord> planned;
  if (number != 0) planned = folder_.schedule()[static_cast<std::size_t>(number) - 1];
  Step("paused", planned ? &*planned : nullptr);
  OperatorRequest request;
  request.kind = OperatorRequest::Kind::kFault;
  request.sentence = error.what();
  if (!options_.ask || !station_.NeedsOperator() || !AskWhileTimeStands(request)) return false;
  folder_.Note({{"event", "unpaused"}, {"number", number}});
  return true;
}

// The frame that was under way when a device failed may be good.
void SessionRunner::SettleInSpiteOf(const DeviceError& fault) {
  try {
    taker_.Settle();
  } catch (const DeviceError& other) {
    spdlog::warn("{} (beside: {})", other.what(), fault.what());  // that frame is taken again
  }
}

const FrameRecord* SessionRunner::NextMissing(int besides, int besides_too) const {
  const bool by_hand = !station_.wheel().MovesByItself();
  const auto rank = [&](const FrameRecord& f) {
    const bool in_place = f.role == placed_ && f.role != FrameRole::kBlack;
    return std::tuple(!in_place, TurnOf(f, folder_.schedule(), by_hand), f.number);
  };
  const FrameRecord* next = nullptr;
  for (const FrameRecord& f : folder_.schedule()) {
    if (f.number == besides || f.number == besides_too || folder_.Has(f)) continue;
    if (next == nullptr || rank(f) < rank(*next)) next = &f;
  }
  return next;
}

int SessionRunner::SlotAfter(const FrameRecord& planned) const {
  const FrameRecord* next = NextMissing(planned.number, taker_.under_way());
  return next != nullptr ? next->slot : 0;
}

}  // namespace dermap
