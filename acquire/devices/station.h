// SPDX-License-Identifier: Apache-2.0
// The devices of one rig together: camera, wheel and what lies in front of them.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "acquire/devices/camera.h"
#include "acquire/devices/filter_wheel.h"
#include "acquire/devices/operator.h"
#include "common/core/progress.h"
#include "common/files/rig.h"
#include "common/files/session.h"

namespace dermap {

class Station {
 public:
  virtual ~Station() = default;
  virtual Camera& camera() = 0;
  virtual FilterWheel& wheel() = 0;
  // Whatever takes time before the first frame: connecting, rendering the simulated scene.
  virtual void Prepare(const ProgressFunction& progress);
  // Whether a person puts the targets in place (and is asked for it before Place).
  virtual bool NeedsOperator() const { return false; }
  // Puts what the role needs at the place of the skin: nothing in particular for black frames, the Spectralon
  // panel, the taped skin. A simulated station does it by itself; for a real one an operator does, who is
  // asked beforehand.
  virtual void Place(FrameRole role) = 0;
  // Whatever belongs into the session folder beside the frames (simulated devices: truth/). Called before the
  // first frame with all frames of the schedule.
  virtual void WriteRecords(const std::filesystem::path& session_directory,
                            std::span<const FrameRecord> schedule);
};

// Quick: the devices are there after Prepare. Throws InputError for a driver that does not exist, listing
// those that do.
// `ask` is for wheels that are turned by hand.
std::unique_ptr<Station> MakeStation(const RigConfig& rig, const AskOperator& ask = {});
const std::vector<std::string>& CameraDrivers();
const std::vector<std::string>& WheelDrivers();

}  // namespace dermap
