// SPDX-License-Identifier: Apache-2.0
// Sets the camera for its next frame; ahead of time where there is some, as while the operator is busy.
#pragma once

#include <future>

#include "acquire/devices/camera.h"
#include "acquire/timeline.h"

namespace dermap {

class CameraSetter {
 public:
  CameraSetter(Camera& camera, const Stopwatch& stopwatch) : camera_(camera), stopwatch_(stopwatch) {}
  ~CameraSetter();  // lets it come to its end
  // Begins; until Finish nobody else may use the camera.
  void Start(const CaptureSettings& settings);
  // Returns once the camera is set so; throws what setting it throws. Returns the time that setting took.
  TimeSpan Finish(const CaptureSettings& settings);

 private:
  TimeSpan Set(const CaptureSettings& settings);
  Camera& camera_;
  const Stopwatch& stopwatch_;
  std::future<TimeSpan> ahead_;
};

}  // namespace dermap
