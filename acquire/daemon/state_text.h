// SPDX-License-Identifier: Apache-2.0
// The daemon's state as text, made once for all who ask.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "acquire/daemon/capture_daemon.h"

namespace dermap {

class StateText {
 public:
  explicit StateText(const CaptureDaemon& daemon)
      : daemon_(daemon), thread_([this] { MakeUntilStopped(); }) {}
  ~StateText();
  StateText(const StateText&) = delete;
  StateText& operator=(const StateText&) = delete;
  // Of this version or a later one, which it waits for; nothing once it is stopped.
  void AppendTo(std::string& text, std::uint64_t version);
  void Stop();

 private:
  void MakeUntilStopped();

  const CaptureDaemon& daemon_;
  std::mutex mutex_;
  std::condition_variable made_;
  std::uint64_t version_ = 0;
  std::string text_;
  bool stopping_ = false;
  std::thread thread_;  // the last member: it uses all others
};

}  // namespace dermap
