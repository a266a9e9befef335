// SPDX-License-Identifier: Apache-2.0
// Takes devices off the bus and puts them back, in a thread of its own: devices ask for it while the bus is
// locked.
#pragma once

#include <condition_variable>
#include <list>
#include <mutex>
#include <thread>

#include "acquire/emulator/usb_bus.h"

namespace dermap::emulator {

class Unplugger {
 public:
  explicit Unplugger(UsbBus& bus);
  ~Unplugger();  // what is off the bus stays so
  // Off at once, on again after `seconds`.
  void Unplug(UsbDevice& device, double seconds);

 private:
  struct Step {
    UsbDevice* device;
    bool plug;
    Clock::time_point when;
  };
  void Run();

  UsbBus& bus_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::list<Step> steps_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace dermap::emulator
