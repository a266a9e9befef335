// SPDX-License-Identifier: Apache-2.0
// The state machine. One thread runs the session; all others only look at its state, or change what it asks
// about.
#include "acquire/daemon/capture_daemon.h"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "acquire/daemon/frame_view.h"
#include "acquire/daemon/state_json.h"
#include "acquire/schedule.h"
#include "common/core/error.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using std::chrono::milliseconds;

constexpr std::size_t kMostWarnings = 50;

}  // namespace

struct CaptureDaemon::Content {
  json about;  // what does not change: rig and plan
  std::map<int, json> frames;
};

CaptureDaemon::CaptureDaemon(DaemonOptions options)
    : options_(std::move(options)), content_(std::make_unique<Content>()) {
  const RigConfig rig = ReadRig(options_.rig);
  const PlanConfig plan = ReadPlan(options_.plan);
  by_hand_ = rig.wheel_driver == "manual";
  content_->about = {{"rig", rig.name},
                     {"camera", rig.camera_driver},
                     {"wheel", rig.wheel_driver},
                     {"plan", options_.plan.filename().string()},
                     {"schedule", ScheduleToJson(InOrderOfTaking(MakeSchedule(rig, plan), by_hand_))}};
  std::error_code error;
  fs::create_directories(options_.root, error);
  if (error) {
    throw StorageError("cannot create the folder of sessions " + options_.root.string() + ": " +
                       error.message() + "; remedy: name another by --root");
  }
  thread_ = std::thread([this] { RunSessions(); });
}

CaptureDaemon::~CaptureDaemon() {
  {
    const std::lock_guard lock(mutex_);
    abort_ = ending_ = true;
    Changed();
  }
  thread_.join();
}

void CaptureDaemon::Changed() {
  ++version_;
  changed_.notify_all();
}

const char* CaptureDaemon::PhaseName(Phase phase) {
  constexpr const char* kNames[]{"idle", "running", "waiting", "paused", "complete", "ended", "failed"};
  return kNames[static_cast<int>(phase)];
}

void CaptureDaemon::Start(const SessionForm& form) {
  RequireFilledIn(form);
  const std::lock_guard lock(mutex_);
  if (Busy()) throw InputError("a session is under way; remedy: end it first");
  retakes_.clear();
  content_->frames.clear();
  thumbnails_.clear();
  Launch(form);
}

void CaptureDaemon::Launch(const SessionForm& form) {
  form_ = form;
  phase_ = Phase::kRunning;
  step_ = "connect";
  problem_.clear();
  warnings_.clear();
  request_.reset();
  frame_.reset();
  answered_ = pause_ = abort_ = false;
  done_ = total_ = 0;
  done_at_start_ = -1;
  started_ = std::chrono::steady_clock::now();
  launched_ = true;
  Changed();
}

void CaptureDaemon::RunSessions() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return launched_ || ending_; });
    if (ending_) return;
    launched_ = false;
    const SessionForm form = form_;
    lock.unlock();
    Run(form);
    malloc_trim(0);  // what a session leaves in pieces would otherwise add up from day to day
    lock.lock();
  }
}

void CaptureDaemon::Answer() {
  const std::lock_guard lock(mutex_);
  if (!request_) throw InputError("nothing was asked");
  answered_ = true;
  Changed();
}

void CaptureDaemon::Pause() {
  const std::lock_guard lock(mutex_);
  if (!Busy()) throw InputError("no session is under way");
  pause_ = true;
  Changed();
}

void CaptureDaemon::Continue() {
  const std::lock_guard lock(mutex_);
  if (!pause_) throw InputError("the session is not paused");
  pause_ = false;
  Changed();
}

void CaptureDaemon::Abort() {
  const std::lock_guard lock(mutex_);
  if (!Busy()) throw InputError("no session is under way");
  abort_ = true;
  Changed();
}

void CaptureDaemon::Retake(int frame_number) {
  const std::lock_guard lock(mutex_);
  if (content_->frames.count(frame_number) == 0) {
    throw InputError("frame " + std::to_string(frame_number) + " was not taken yet");
  }
  retakes_.push_back(frame_number);
  if (Busy()) return Changed();
  SessionForm form = form_;
  form.resume = true;
  form.reference.clear();
  Launch(form);
}

bool CaptureDaemon::Ask(const OperatorRequest& request) {
  if (options_.on_request) options_.on_request(request);
  std::unique_lock lock(mutex_);
  request_ = request;
  answered_ = false;
  phase_ = Phase::kWaiting;
  Changed();
  changed_.wait(lock, [&] { return answered_ || abort_; });
  request_.reset();
  phase_ = Phase::kRunning;
  Changed();
  return !abort_;
}

bool CaptureDaemon::ShallStop() {
  std::unique_lock lock(mutex_);
  if (pause_ && !abort_) {
    phase_ = Phase::kPaused;
    Changed();
    changed_.wait(lock, [&] { return !pause_ || abort_; });
    phase_ = Phase::kRunning;
    Changed();
  }
  return abort_;
}

bool CaptureDaemon::Pauses() {
  const std::lock_guard lock(mutex_);
  return pause_ && !abort_;
}

std::optional<int> CaptureDaemon::NextRetake() {
  const std::lock_guard lock(mutex_);
  if (retakes_.empty() || abort_) return std::nullopt;
  const int number = retakes_.front();
  retakes_.pop_front();
  return number;
}

void CaptureDaemon::AddWarning(const std::string& warning) {
  if (!warning.empty() && warnings_.size() < kMostWarnings) warnings_.push_back(warning);
}

void CaptureDaemon::OnFrame(const FrameEvent& event, const RawFrame& raw) {
  const FrameView view = MakeFrameView(raw);
  const std::lock_guard lock(mutex_);
  if (done_at_start_ < 0) {
    done_at_start_ = event.done - 1;
    started_ = std::chrono::steady_clock::now();
  }
  done_ = event.done;
  total_ = event.total;
  // A frame that is taken again has another picture.
  content_->frames[event.frame.number] = TakenFrameToJson(event, view, version_);
  thumbnails_[event.frame.number] = view.png;
  AddWarning(event.warning);
  Changed();
}

void CaptureDaemon::Run(const SessionForm& form) {
  CaptureOptions options;
  options.rig = options_.rig;
  options.plan = options_.plan;
  options.out = options_.root / form.session;
  options.resume = form.resume;
  if (!form.reference.empty()) options.reference = options_.root / form.reference;
  options.subject = SubjectForm{form.subject, form.site, form.notes};
  options.ask = [this](const OperatorRequest& request) { return Ask(request); };
  options.stop = [this] { return ShallStop(); };
  options.pauses = [this] { return Pauses(); };
  options.retake = [this] { return NextRetake(); };
  options.on_step = [this](const std::string& step, const FrameRecord* frame) {
    const std::lock_guard lock(mutex_);
    step_ = step;
    frame_ = frame != nullptr ? std::optional(*frame) : std::nullopt;
    Changed();
  };
  options.on_frame = [this](const FrameEvent& event, const RawFrame& raw) { OnFrame(event, raw); };
  options.on_schedule = [this](const std::vector<FrameRecord>& schedule, const std::string& why) {
    const std::lock_guard lock(mutex_);
    content_->about["schedule"] = ScheduleToJson(InOrderOfTaking(schedule, by_hand_));
    total_ = static_cast<int>(schedule.size());
    AddWarning(why);
    Changed();
  };
  Phase end = Phase::kFailed;
  std::string problem;
  try {
    const CaptureSummary summary = RunCapture(options);
    end = summary.session.complete ? Phase::kComplete : Phase::kEnded;
  } catch (const std::exception& error) {
    problem = error.what();
    spdlog::warn("session {}: {}", form.session, problem);
  }
  const std::lock_guard lock(mutex_);
  // An operator who ends a session at a fault has not failed.
  phase_ = end == Phase::kFailed && abort_ ? Phase::kEnded : end;
  problem_ = problem;
  step_.clear();
  frame_.reset();
  Changed();
}

json CaptureDaemon::State() const {
  const std::lock_guard lock(mutex_);
  json s = content_->about;
  s["version"] = version_;
  s["state"] = PhaseName(phase_);
  s["step"] = step_;
  s["session"] = form_.session;
  s["subject"] = form_.subject;
  s["site"] = form_.site;
  s["notes"] = form_.notes;
  s["done"] = done_;
  s["problem"] = problem_;
  s["warnings"] = warnings_;
  s["pausing"] = pause_ && phase_ != Phase::kPaused;
  s["frame"] = frame_ ? PlannedFrameToJson(*frame_) : json(nullptr);
  s["request"] = request_ ? RequestToJson(*request_) : json(nullptr);
  s["seconds_left"] = nullptr;
  if (Busy() && done_at_start_ >= 0 && done_ > done_at_start_ + 1) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started_;
    s["seconds_left"] = elapsed.count() / (done_ - done_at_start_ - 1) * (total_ - done_);
  }
  s["frames"] = json::array();
  for (const auto& [number, frame] : content_->frames) s["frames"].push_back(frame);
  return s;
}

std::uint64_t CaptureDaemon::Version() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

std::uint64_t CaptureDaemon::WaitBeyond(std::uint64_t version, milliseconds limit) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, limit, [&] { return version_ != version || ending_; });
  return version_;
}

std::string CaptureDaemon::Thumbnail(int frame_number) const {
  const std::lock_guard lock(mutex_);
  const auto found = thumbnails_.find(frame_number);
  return found == thumbnails_.end() ? "" : found->second;
}

}  // namespace dermap
