// SPDX-License-Identifier: Apache-2.0
// Waiting for changes, in a thread of its own.
#include "acquire/daemon/state_text.h"

#include <nlohmann/json.hpp>

namespace dermap {
namespace {

constexpr std::chrono::milliseconds kLookForTheEnd{100};

}  // namespace

StateText::~StateText() {
  Stop();
  thread_.join();
}

void StateText::Stop() {
  const std::lock_guard lock(mutex_);
  stopping_ = true;
  made_.notify_all();
}

void StateText::AppendTo(std::string& text, std::uint64_t version) {
  std::unique_lock lock(mutex_);
  made_.wait(lock, [&] { return version_ >= version || stopping_; });
  if (!stopping_) text += text_;
}

void StateText::MakeUntilStopped() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const std::uint64_t seen = version_;
    lock.unlock();
    const std::uint64_t now = daemon_.WaitBeyond(seen, kLookForTheEnd);
    std::string text;
    if (now != seen) text = daemon_.State().dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    lock.lock();
    if (now == seen) continue;
    version_ = now;
    text_ = std::move(text);
    made_.notify_all();
  }
}

}  // namespace dermap
