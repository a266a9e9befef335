// SPDX-License-Identifier: Apache-2.0
// What is done with the devices, and with a frame once it is known.
#include "acquire/frame_taker.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "acquire/devices/device_fault.h"
#include "acquire/frame_warning.h"
#include "acquire/schedule.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr int kMostChanges = 4;  // of one filter's exposure

}  // namespace

FrameTaker::FrameTaker(SessionFolder& folder, Station& station, const CaptureOptions& options,
                       CaptureSummary& summary, const Stopwatch& stopwatch)
    : folder_(folder),
      station_(station),
      options_(options),
      summary_(summary),
      stopwatch_(stopwatch),
      wheel_(station.wheel(), stopwatch),
      setter_(station.camera(), stopwatch) {}

void FrameTaker::Step(const std::string& what, const FrameRecord& frame) {
  if (options_.on_step) options_.on_step(what, &frame);
}

void FrameTaker::Warn(const std::string& warning) {
  if (!warning.empty()) summary_.warnings.push_back(warning);
}

void FrameTaker::Take(const FrameRecord& planned, int slot_after) {
  summary_.timeline.frames.push_back({});
  Timing().number = planned.number;
  if (!Prepare(planned)) {
    summary_.timeline.frames.pop_back();
    return;
  }
  auto taken = std::make_unique<Pending>();
  taken->planned = planned;
  taken->timing = summary_.timeline.frames.size() - 1;
  taken->time_utc = Expose(planned);
  if (slot_after != 0) wheel_.Start(slot_after);
  const std::string lost = Fetch(planned, taken->raw);
  const std::unique_ptr<Pending> before = std::move(pending_);
  if (lost.empty()) Examine(std::move(taken));
  if (before) ActOn(*before, Judge(*before));
  if (!lost.empty()) Reject(planned.number, "was lost: " + lost);
}

void FrameTaker::Settle() {
  if (!pending_) return;
  const std::unique_ptr<Pending> settled = std::move(pending_);
  ActOn(*settled, Judge(*settled));
}

// All that can be done before the shutter is pressed.
bool FrameTaker::Prepare(const FrameRecord& planned) {
  FrameTiming& timing = Timing();
  const CaptureSettings settings{planned.exposure_ms, planned.iso, planned.number};
  Step("move", planned);
  timing.ready = setter_.Finish(settings);  // while the wheel turns and the flash recycles
  wheel_.Finish(planned.slot);
  timing.wheel = wheel_.TakeSpan();
  if (!flash_ready_) return true;
  // It takes the camera a while to press; the quickest press so far is what may be counted on.
  const Clock::time_point press = *flash_ready_ - quickest_press_.value_or(Clock::duration{});
  const bool there_is_time = Clock::now() < press;
  if (pending_ && there_is_time && pending_->examining.wait_until(press) == std::future_status::ready) {
    const int before = under_way();
    Settle();
    const auto& schedule = folder_.schedule();
    if (!folder_.Has(schedule[static_cast<std::size_t>(before) - 1])) return false;
  }
  std::this_thread::sleep_until(press);
  return true;
}

std::string FrameTaker::Expose(const FrameRecord& planned) {
  FrameTiming& timing = Timing();
  Step("expose", planned);
  timing.expose.start_s = stopwatch_.Now();
  const Clock::time_point start = Clock::now();
  const Clock::time_point pressed =
      station_.camera().Expose({planned.exposure_ms, planned.iso, planned.number});
  timing.expose.end_s = stopwatch_.Now();
  quickest_press_ = std::min(quickest_press_.value_or(pressed - start), pressed - start);
  const double recycle_s = folder_.session().rig.flash_recycle_s;
  timing.flash.start_s = stopwatch_.At(pressed);
  timing.flash.end_s = timing.flash.start_s + recycle_s;
  // From press to flash is the same time for every frame.
  flash_ready_ =
      pressed + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(recycle_s));
  return NowUtc();
}

// The frame before is written meanwhile.
std::string FrameTaker::Fetch(const FrameRecord& planned, RawFrame& raw) {
  FrameTiming& timing = Timing();
  Step("fetch", planned);
  timing.fetch.start_s = stopwatch_.Now();
  auto fetching = std::async(std::launch::async, [this, &raw] {
    raw = station_.camera().Fetch();
    return stopwatch_.Now();
  });
  if (pending_ && KeepIfGood()) pending_.reset();
  try {
    timing.fetch.end_s = fetching.get();
    return "";
  } catch (const DeviceFault&) {
    throw;  // it lasts
  } catch (const DeviceError& lost) {
    timing.fetch.end_s = stopwatch_.Now();
    return lost.what();
  }
}

void FrameTaker::Examine(std::unique_ptr<Pending> taken) {
  pending_ = std::move(taken);
  pending_->examining = std::async(std::launch::async, [this, &raw = pending_->raw] {
    Examination e;
    e.span.start_s = stopwatch_.Now();
    e.check = CheckFrame(raw, folder_.session().rig.gray_card_region);
    e.sha256 = Sha256(raw.bytes);
    e.span.end_s = stopwatch_.Now();
    return e;
  });
}

FrameTaker::Verdict FrameTaker::Judge(Pending& pending) {
  if (!pending.found) {
    pending.found = pending.examining.get();
    summary_.timeline.frames[pending.timing].check = pending.found->span;
  }
  const FrameRecord& planned = pending.planned;
  const FrameCheck& check = pending.found->check;
  Verdict v;
  if (!check.decodes) {
    v.problem = check.problem;
    return v;
  }
  if (const int copy = folder_.NumberOfCopy(pending.found->sha256); copy != 0 && copy != planned.number) {
    v.problem = "is the file of frame " + std::to_string(copy) + " once more";
    return v;
  }
  v.problem = WrongSettings(planned, check, light_.size());
  v.wrong_settings = !v.problem.empty();
  if (v.wrong_settings) return v;
  v.light = light_.Judge(planned, check);
  if (v.light.problem != LightProblem::kNone && !IsTolerable(v.light.problem, planned))
    v.problem = DescribeLight(v.light);
  const Session& session = folder_.session();
  const bool adapts = session.plan.adapt_exposure && v.light.problem == LightProblem::kNone &&
                      folder_.ChangesOf(planned) < kMostChanges;
  if (adapts) v.advice = AdviseExposure(planned, check, session.rig.gray_card_reflectance);
  return v;
}

// A drifting lamp and a flash that stays dark are the operator's to judge: kept in the end, with a warning.
// But dark may be the opaque slot: whoever can be asked is asked first. Dark Spectralon is never kept, since
// nothing can be calibrated by it, nor is a frame of another filter.
bool FrameTaker::IsTolerable(LightProblem problem, const FrameRecord& planned) const {
  if (!doubts_.IsLastTry(planned.number)) return false;
  if (problem == LightProblem::kBright) return true;
  const bool can_be_asked = options_.ask && station_.NeedsOperator();
  return problem == LightProblem::kDark && planned.role != FrameRole::kSpectralon &&
         (!can_be_asked || doubts_.WasSeenTo(planned.number));
}

bool FrameTaker::KeepIfGood() {
  const Verdict verdict = Judge(*pending_);
  if (!verdict.problem.empty() || verdict.advice.problem != ExposureProblem::kNone) return false;
  if (!IsStillPlanned(*pending_)) return false;
  Keep(*pending_, verdict);
  return true;
}

void FrameTaker::ActOn(Pending& pending, const Verdict& verdict) {
  const FrameRecord& planned = pending.planned;
  if (!IsStillPlanned(pending)) return;  // it is taken anew at its new exposure
  if (verdict.problem.empty()) {
    if (!Adapt(planned, verdict.advice)) Keep(pending, verdict);
    return;
  }
  if (verdict.wrong_settings) {
    station_.camera().Reconnect();  // libgphoto2 may believe in settings that somebody has changed by hand
  }
  if (verdict.light.problem == LightProblem::kOtherSlot && doubts_.WheelIsRight(planned.number)) {
    // The wheel stands where it should, so it did not when this slot's light was learnt.
    Withdraw(light_.SourceOf(planned.slot),
             "was taken through another filter, as " + DescribeFrame(planned) + " shows");
    light_.Forget(planned.slot);
    return ActOn(pending, Judge(pending));
  }
  if (doubts_.IsOfAnotherSlot(planned.number, verdict.light.problem)) {
    wheel_.Home();
    doubts_.NoteHoming(planned.number, station_.wheel().HomingFindsSlots(), under_way());
  }
  Reject(planned.number, verdict.problem);
}

void FrameTaker::Withdraw(int number, const std::string& why) {
  const FrameRecord frame = folder_.schedule()[static_cast<std::size_t>(number) - 1];
  spdlog::warn("{} {}; it is taken again", DescribeFrame(frame), why);
  Warn(DescribeFrame(frame) + " " + why + "; it is taken again");
  light_.Forget(frame.slot);
  folder_.Withdraw(number, why);
}

// The change that a frame before it asked for may have been for this one as well.
bool FrameTaker::IsStillPlanned(const Pending& pending) const {
  return SamePlace(pending.planned, folder_.schedule()[static_cast<std::size_t>(pending.planned.number) - 1]);
}

void FrameTaker::Reject(int number, const std::string& problem) {
  const FrameRecord planned = folder_.schedule()[static_cast<std::size_t>(number) - 1];
  const int times = doubts_.CountRejection(number);
  spdlog::warn("{} {}; attempt {} of {}", DescribeFrame(planned), problem, times, kFrameTries);
  folder_.Note({{"event", "frame_rejected"}, {"number", number}, {"problem", problem}});
  if (times < kFrameTries) return;
  throw FrameGivenUp(number,
                     station_.camera().Name() + ": " + DescribeFrame(planned) + " " + problem + " (" +
                         std::to_string(kFrameTries) +
                         " attempts); remedy: check camera, wheel and flash, then go on with --resume");
}

// A frame too dark may be one weak flash: only a second one is believed. A frame too bright is not to be had
// from one.
bool FrameTaker::Adapt(const FrameRecord& planned, const ExposureAdvice& advice) {
  if (advice.problem == ExposureProblem::kNone) return false;
  if (advice.problem == ExposureProblem::kUnderexposed && !doubts_.LooksUnderexposedAgain(planned.number)) {
    if (doubts_.IsLastTry(planned.number)) return false;
    Reject(planned.number, "seems underexposed: " + advice.why + "; taken once more to be sure");
    return true;
  }
  const auto iso = IsoThatCameraTakes(planned, advice.isos);
  if (!iso) return false;
  const std::string why = DescribeFrame(planned) + ": " + advice.why;
  folder_.ChangeExposure({planned.role, planned.slot, planned.iso, *iso, planned.number, why, ""});
  schedule_changed_ = true;
  doubts_.TryAnew(planned.number);
  const std::string notice = why + "; slot " + std::to_string(planned.slot) + " is taken at ISO " +
                             std::to_string(*iso) + " in place of " + std::to_string(planned.iso);
  spdlog::warn("{}", notice);
  Warn(notice);
  if (options_.on_schedule) options_.on_schedule(folder_.schedule(), notice);
  return true;
}

std::optional<int> FrameTaker::IsoThatCameraTakes(const FrameRecord& planned, const std::vector<int>& isos) {
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

void FrameTaker::Keep(const Pending& pending, const Verdict& verdict) {
  const FrameRecord& planned = pending.planned;
  FrameTiming& timing = summary_.timeline.frames[pending.timing];
  FrameEvent event;
  timing.good = true;
  timing.write.start_s = stopwatch_.Now();
  event.frame = folder_.Add(planned, pending.raw, pending.time_utc);
  timing.write.end_s = stopwatch_.Now();
  event.timing = timing;
  event.check = pending.found->check;
  if (verdict.light.problem == LightProblem::kNone) light_.Learn(planned, event.check);
  event.drift = verdict.light.drift;
  event.done = folder_.done();
  event.total = folder_.total();
  event.warning =
      WarningAbout(planned, event.check, verdict.light, folder_.session().rig.gray_card_reflectance);
  Warn(event.warning);
  ++summary_.taken;
  progress_ =
      std::max(progress_, kShareOfPreparation + (1.0 - kShareOfPreparation) * event.done / event.total);
  if (options_.progress) options_.progress(progress_);
  if (options_.on_frame) options_.on_frame(event, pending.raw);
  for (const int number : doubts_.Vouch(planned))
    Withdraw(number, "may have been taken through another filter: the wheel stood one slot off");
}

}  // namespace dermap
