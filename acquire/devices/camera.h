// SPDX-License-Identifier: Apache-2.0
// A camera that takes one raw frame at a time, with the flash fired by it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dermap {

struct CaptureSettings {
  double exposure_ms = 10.0;
  int iso = 100;
  int shot = 1;  // number of the frame in its session; a simulated camera draws the shot's noise by it
};

// The camera's own file, untouched.
struct RawFrame {
  std::vector<std::byte> bytes;
  std::string extension;  // with the dot: ".dng", ".cr2"
};

class Camera {
 public:
  virtual ~Camera() = default;
  virtual std::string Name() const = 0;
  virtual void Connect() {}                       // finds it and makes it ready; throws DeviceError
  virtual std::uintmax_t FrameBytes() const = 0;  // about, for the free-space check
  // Begins anew with it, where what it does is not what it says; throws DeviceError.
  virtual void Reconnect() {}
  // Whether it can be set so; throws DeviceError where not.
  virtual void Check(const CaptureSettings&) {}
  // How many more frames its card takes, where it tells.
  virtual std::optional<int> RoomForFrames() { return std::nullopt; }
  // Sets it for the next exposure, so that this takes no time then. Throws DeviceError.
  virtual void MakeReady(const CaptureSettings&) {}
  // Returns once the shutter has closed: whatever is in front of it may move; says when it was pressed.
  // Throws DeviceError.
  virtual std::chrono::steady_clock::time_point Expose(const CaptureSettings& settings) = 0;
  // The frame of the last exposure. Throws DeviceError, and then that frame has to be exposed again.
  virtual RawFrame Fetch() = 0;
};

}  // namespace dermap
