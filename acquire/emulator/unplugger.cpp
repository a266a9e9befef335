// SPDX-License-Identifier: Apache-2.0
// A list of steps, done when their time comes.
#include "acquire/emulator/unplugger.h"

#include <algorithm>

namespace dermap::emulator {

Unplugger::Unplugger(UsbBus& bus) : bus_(bus), thread_([this] { Run(); }) {}

Unplugger::~Unplugger() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Unplugger::Unplug(UsbDevice& device, double seconds) {
  {
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    steps_.push_back({&device, false, now});
    steps_.push_back(
        {&device, true,
         now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))});
  }
  wake_.notify_all();
}

void Unplugger::Run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto first = std::min_element(steps_.begin(), steps_.end(),
                                        [](const Step& a, const Step& b) { return a.when < b.when; });
    if (first == steps_.end()) {
      wake_.wait(lock);
    } else if (first->when > Clock::now()) {
      wake_.wait_until(lock, first->when);
    } else {
      const Step step = *first;
      steps_.erase(first);
      lock.unlock();
      if (step.plug) {
        bus_.Plug(*step.device);
      } else {
        bus_.Unplug(*step.device);
      }
      lock.lock();
    }
  }
}

}  // namespace dermap::emulator
