// SPDX-License-Identifier: Apache-2.0
// Which fault is met by what: busy by asking again, a lost or silent camera by a new connection, a silent
// helper by a new helper.
#include "acquire/devices/gphoto2_camera.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <tuple>
#include <utility>

#include "acquire/devices/camera_helper.h"

namespace dermap {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

constexpr milliseconds kLongestPause{3000};
constexpr int kBusyBeforeReopening = 3;

}  // namespace

Gphoto2Camera::Gphoto2Camera(CameraChoice choice, const CameraPatience& patience)
    : choice_(std::move(choice)), patience_(patience), helper_(std::make_unique<CameraHelper>()) {}

Gphoto2Camera::~Gphoto2Camera() {
  CloseConnection();  // leaves the camera usable by hand
}

int Gphoto2Camera::helper_pid() const {
  return helper_->pid();
}

void Gphoto2Camera::Open() {
  const json request{{"do", "open"},
                     {"port", choice_.port},
                     {"model", choice_.model},
                     {"answer_ms", patience_.answer.count()}};
  const CameraAnswer answer = helper_->Ask(request, patience_.call, name_);
  set_.reset();
  if (const std::string model = answer.Text("model"); !model.empty()) name_ = model;
  if (answer.Says("old_driver")) {
    spdlog::warn("{} is driven by an old driver that cannot be triggered: best effort", name_);
  }
  open_ = true;
}

void Gphoto2Camera::CloseConnection() {
  open_ = false;
  set_.reset();
  try {
    if (helper_->running()) helper_->Tell({{"do", "close"}}, patience_.answer);
  } catch (const DeviceFault&) {
    // It hangs in closing too: Ask has killed it.
  }
}

void Gphoto2Camera::Reconnect() {
  CloseConnection();
  Connect();
}

void Gphoto2Camera::Recover(const DeviceFault& fault, int attempt) {
  spdlog::warn("{}; attempt {} of {}", fault.what(), attempt, patience_.attempts);
  if (on_retry) on_retry(fault);
  const bool just_busy = fault.kind() == FaultKind::kBusy && attempt <= kBusyBeforeReopening;
  if (!just_busy && open_) {
    CloseConnection();
  } else if (!just_busy) {
    // A second connection that fails as the first does may be libgphoto2's own state: a new process has none.
    helper_->Kill();
  }
  const int doublings = std::min(attempt - 1, 8);
  std::this_thread::sleep_for(std::min(kLongestPause, patience_.first_pause * (1 << doublings)));
}

void Gphoto2Camera::Insist(const std::string& doing, const std::function<void()>& step) {
  const auto start = std::chrono::steady_clock::now();
  for (int attempt = 1;; ++attempt) {
    try {
      if (!open_) Open();
      return step();
    } catch (const DeviceFault& fault) {
      const bool hopeless = fault.kind() == FaultKind::kSettings || fault.kind() == FaultKind::kFull ||
                            fault.kind() == FaultKind::kNoPermission;
      // What is off the bus is waited for by the clock, the rest by the count.
      const bool waits =
          fault.kind() == FaultKind::kGone && std::chrono::steady_clock::now() - start < patience_.plug_in;
      if (hopeless || (!waits && attempt >= patience_.attempts)) {
        spdlog::warn("{}: gave up to {} after {} attempts", name_, doing, attempt);
        throw;
      }
      Recover(fault, attempt);
    }
  }
}

void Gphoto2Camera::Connect() {
  Insist("connect", [] {});
}

void Gphoto2Camera::Set(const CaptureSettings& s) {
  if (set_ && set_->iso == s.iso && set_->exposure_ms == s.exposure_ms) return;
  set_.reset();
  helper_->Ask({{"do", "set"}, {"iso", s.iso}, {"exposure_ms", s.exposure_ms}}, patience_.call, name_);
  set_ = s;  // until the next shot, which may fill the card
}

void Gphoto2Camera::Check(const CaptureSettings& settings) {
  Insist("be set", [&] { Set(settings); });
}

std::optional<int> Gphoto2Camera::RoomForFrames() {
  std::optional<int> room;
  Insist("tell its room", [&] {
    const int left = helper_->Ask({{"do", "room"}}, patience_.call, name_).Number("room", -1);
    room = left >= 0 ? std::optional(left) : std::nullopt;
  });
  return room;
}

std::chrono::steady_clock::time_point Gphoto2Camera::ExposeOnce(const CaptureSettings& s) {
  Set(s);
  set_.reset();
  const auto open = patience_.shutter + milliseconds(std::lround(s.exposure_ms));
  const auto quiet = files_owed_ > 0 ? patience_.quiet : milliseconds(0);
  // From here on a file may come; until it has, one is owed.
  helper_->Ask({{"do", "expose"}, {"open_ms", open.count()}, {"quiet_ms", quiet.count()}},
               patience_.call + open + quiet, name_);
  return std::chrono::steady_clock::now() - open;
}

std::chrono::steady_clock::time_point Gphoto2Camera::Expose(const CaptureSettings& settings) {
  std::chrono::steady_clock::time_point pressed;
  folder_.clear();
  file_.clear();
  Insist("expose", [&] {
    try {
      pressed = ExposeOnce(settings);
    } catch (const DeviceFault& fault) {
      // The shutter may have opened all the same.
      if (fault.kind() == FaultKind::kNoAnswer || fault.kind() == FaultKind::kGone) ++files_owed_;
      throw;
    }
  });
  ++files_owed_;
  return pressed;
}

bool Gphoto2Camera::IsOfAnEarlierShot(const std::string& folder, const std::string& file) const {
  return folder != "/" && folder == last_folder_ && file <= last_file_;
}

// Where the frame of the last shot lies. A file of a shot that was given up may come at any time, even after
// the next frame has been fetched: its number is lower. While several are owed, the last to come is the last
// shot's.
void Gphoto2Camera::FindFile() {
  bool again = false;
  const auto await = [&](milliseconds limit) {
    const CameraAnswer place = helper_->Ask({{"do", "fetch"}, {"limit_ms", limit.count()}, {"again", again}},
                                            patience_.call + limit, name_);
    again = true;
    return std::pair(place.Text("folder"), place.Text("name"));
  };
  do {
    std::tie(folder_, file_) = await(patience_.file);
  } while (IsOfAnEarlierShot(folder_, file_));
  for (int owed = files_owed_; owed > 1; --owed) {
    try {
      const auto [folder, file] = await(patience_.quiet);
      if (std::pair(folder, file) > std::pair(folder_, file_))
        std::tie(folder_, file_) = std::pair(folder, file);
    } catch (const DeviceFault&) {
      return;  // no more have come
    }
  }
}

RawFrame Gphoto2Camera::FetchOnce() {
  if (file_.empty()) FindFile();
  const CameraAnswer answer =
      helper_->Ask({{"do", "fetch"}, {"folder", folder_}, {"name", file_}}, patience_.call, name_);
  RawFrame frame;
  frame.bytes = answer.bytes;
  frame.extension = FrameExtension(file_);
  return frame;
}

RawFrame Gphoto2Camera::Fetch() {
  RawFrame frame;
  Insist("fetch the frame", [&] {
    try {
      frame = FetchOnce();
    } catch (const DeviceFault& fault) {
      // A frame that lies on the card can be fetched over a new connection. One whose file never came, or
      // that lay in the camera's memory ("/") alone, is lost with this one: whoever asked has to expose it
      // again.
      if (!file_.empty() && folder_ != "/") throw;
      if (fault.kind() != FaultKind::kBusy) open_ = false;
      if (helper_->running()) helper_->Kill();
      throw DeviceError(fault.what());
    }
  });
  files_owed_ = 0;
  if (folder_ != "/") std::tie(last_folder_, last_file_) = std::tie(folder_, file_);
  frame_bytes_ = std::max<std::uintmax_t>(frame.bytes.size(), 1);
  return frame;
}

std::vector<AttachedCamera> ListCameras() {
  CameraHelper helper;
  const CameraAnswer answer = helper.Tell({{"do", "list"}}, milliseconds(20000));
  std::vector<AttachedCamera> cameras;
  const json found = json::parse(answer.line);
  if (!found.contains("cameras")) return cameras;
  for (const json& c : found["cameras"]) {
    cameras.push_back({c.value("model", ""), c.value("port", ""), c.value("driver", "")});
  }
  return cameras;
}

}  // namespace dermap
