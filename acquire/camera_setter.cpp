// SPDX-License-Identifier: Apache-2.0
// A camera that is set already is set in no time: setting it again costs nothing, and tells what has changed
// since.
#include "acquire/camera_setter.h"

#include <utility>

#include "common/core/error.h"

namespace dermap {

CameraSetter::~CameraSetter() {
  if (ahead_.valid()) ahead_.wait();
}

TimeSpan CameraSetter::Set(const CaptureSettings& settings) {
  TimeSpan span{stopwatch_.Now(), 0.0};
  camera_.MakeReady(settings);
  span.end_s = stopwatch_.Now();
  return span;
}

void CameraSetter::Start(const CaptureSettings& settings) {
  if (ahead_.valid()) ahead_.wait();
  ahead_ = std::async(std::launch::async, [this, settings] { return Set(settings); });
}

TimeSpan CameraSetter::Finish(const CaptureSettings& settings) {
  if (!ahead_.valid()) return Set(settings);
  try {
    const TimeSpan ahead = std::exchange(ahead_, {}).get();
    Set(settings);
    return ahead;
  } catch (const DeviceError&) {
    return Set(settings);  // what lasts is thrown now, where it is met
  }
}

}  // namespace dermap
