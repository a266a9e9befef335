// SPDX-License-Identifier: Apache-2.0
// One station, run for whoever talks to it: a state machine around RunCapture, its state as JSON, and a word
// to all who watch whenever that changes. Knows nothing of HTTP.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "acquire/daemon/session_form.h"
#include "acquire/sequence.h"

namespace dermap {

struct DaemonOptions {
  std::filesystem::path rig;
  std::filesystem::path plan;
  std::filesystem::path root;  // session folders lie in it, and nowhere else
  // Told of whatever the operator is asked for, for the log.
  std::function<void(const OperatorRequest&)> on_request{};
};

class CaptureDaemon {
 public:
  explicit CaptureDaemon(DaemonOptions options);
  ~CaptureDaemon();  // ends a session that runs, to be resumed
  CaptureDaemon(const CaptureDaemon&) = delete;
  CaptureDaemon& operator=(const CaptureDaemon&) = delete;

  // Each throws InputError where it does not fit the state; all return at once.
  void Start(const SessionForm& form);
  void Answer();  // what the operator was asked for is done
  void Pause();
  void Continue();
  void Abort();  // ends the session after the frame under way, to be resumed
  void Retake(int frame_number);

  nlohmann::json State() const;
  // The state's number: another one is another state.
  std::uint64_t Version() const;
  // Waits for a state beyond `version`; returns its number, or `version` when the time is over or the daemon
  // ends.
  std::uint64_t WaitBeyond(std::uint64_t version, std::chrono::milliseconds limit) const;
  // PNG of a frame of the session under way, empty where there is none.
  std::string Thumbnail(int frame_number) const;

 private:
  enum class Phase { kIdle, kRunning, kWaiting, kPaused, kComplete, kEnded, kFailed };
  void RunSessions();  // those that are launched, until the daemon ends
  void Run(const SessionForm& form);
  bool Ask(const OperatorRequest& request);
  bool ShallStop();
  bool Pauses();
  std::optional<int> NextRetake();
  void OnFrame(const FrameEvent& event, const RawFrame& raw);
  void Launch(const SessionForm& form);
  void AddWarning(const std::string& warning);  // with the lock held; empty: none
  void Changed();                               // with the lock held
  static const char* PhaseName(Phase phase);
  bool Busy() const {
    return phase_ == Phase::kRunning || phase_ == Phase::kWaiting || phase_ == Phase::kPaused;
  }

  DaemonOptions options_;
  struct Content;  // what is JSON: rig and plan, and the frames so far
  std::unique_ptr<Content> content_;
  bool by_hand_ = false;  // a person turns the wheel
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::uint64_t version_ = 1;
  Phase phase_ = Phase::kIdle;
  SessionForm form_;
  std::string step_, problem_;
  std::optional<FrameRecord> frame_;
  std::optional<OperatorRequest> request_;
  bool answered_ = false, pause_ = false, abort_ = false, ending_ = false;
  int done_ = 0, total_ = 0;
  std::chrono::steady_clock::time_point started_{};
  int done_at_start_ = -1;
  std::deque<int> retakes_;
  std::map<int, std::string> thumbnails_;
  std::vector<std::string> warnings_;
  bool launched_ = false;
  // One for all sessions: OpenCV keeps a little of every thread that it has ever seen.
  std::thread thread_;
};

}  // namespace dermap
