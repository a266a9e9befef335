// SPDX-License-Identifier: Apache-2.0
// Connecting.
#include "acquire/devices/device_station.h"

#include <future>

namespace dermap {

void DeviceStation::Prepare(const ProgressFunction& progress) {
  // The wheel finds its slots meanwhile.
  auto wheel = std::async(std::launch::async, [this] { wheel_->Connect(); });
  camera_->Connect();
  if (progress) progress(0.5);
  wheel.get();
  if (progress) progress(1.0);
}

}  // namespace dermap
