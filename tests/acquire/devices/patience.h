// SPDX-License-Identifier: Apache-2.0
// For tests: how long the camera's driver waits where the camera is an emulated one that hurries.
#pragma once

#include "acquire/devices/gphoto2_camera.h"

namespace dermap {

inline constexpr CameraPatience kQuickCamera{.plug_in = std::chrono::milliseconds(5000),
                                             .answer = std::chrono::milliseconds(400),
                                             .call = std::chrono::milliseconds(4000),
                                             .file = std::chrono::milliseconds(1500),
                                             .quiet = std::chrono::milliseconds(300),
                                             .shutter = std::chrono::milliseconds(5),
                                             .first_pause = std::chrono::milliseconds(20),
                                             .attempts = 6};

}  // namespace dermap
