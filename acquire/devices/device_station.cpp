// SPDX-License-Identifier: Apache-2.0
// Connecting.
#include "acquire/devices/device_station.h"

namespace dermap {

void DeviceStation::Prepare(const ProgressFunction& progress) {
  camera_->Connect();
  if (progress) progress(0.5);
  wheel_->Connect();
  if (progress) progress(1.0);
}

}  // namespace dermap
