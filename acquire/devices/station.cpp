// SPDX-License-Identifier: Apache-2.0
// The table of drivers.
#include "acquire/devices/station.h"

#include <algorithm>

#include "acquire/devices/device_station.h"
#include "acquire/devices/gphoto2_camera.h"
#include "acquire/devices/manual_wheel.h"
#include "acquire/devices/usb_wheel.h"
#include "acquire/simulated/simulated_station.h"
#include "common/core/error.h"

namespace dermap {
namespace {

void RequireKnown(const std::string& what, const std::string& driver, const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), driver) != known.end()) return;
  std::string list;
  for (const std::string& k : known) list += (list.empty() ? "\"" : ", \"") + k + "\"";
  throw InputError("The rig names the " + what + " driver \"" + driver +
                   "\", which does not exist; known: " + list + ".");
}

std::unique_ptr<FilterWheel> MakeWheel(const RigConfig& rig, const AskOperator& ask) {
  if (rig.wheel_driver == "starlight") return MakeStarlightWheel(rig.wheel_serial);
  if (rig.wheel_driver == "thorlabs") return MakeThorlabsWheel(rig.wheel_serial);
  return std::make_unique<ManualWheel>(rig, ask);
}

}  // namespace

void Station::Prepare(const ProgressFunction&) {}
void Station::WriteRecords(const std::filesystem::path&, std::span<const FrameRecord>) {}

const std::vector<std::string>& CameraDrivers() {
  static const std::vector<std::string> kDrivers{"simulated", "gphoto2"};
  return kDrivers;
}

const std::vector<std::string>& WheelDrivers() {
  static const std::vector<std::string> kDrivers{"simulated", "starlight", "thorlabs", "manual"};
  return kDrivers;
}

std::unique_ptr<Station> MakeStation(const RigConfig& rig, const AskOperator& ask) {
  RequireKnown("camera", rig.camera_driver, CameraDrivers());
  RequireKnown("wheel", rig.wheel_driver, WheelDrivers());
  const bool simulated_camera = rig.camera_driver == "simulated",
             simulated_wheel = rig.wheel_driver == "simulated";
  if (simulated_camera != simulated_wheel) {
    throw InputError("The rig mixes a simulated device with a real one (camera \"" + rig.camera_driver +
                     "\", wheel \"" + rig.wheel_driver + "\"); the light of one knows nothing of the other.");
  }
  if (simulated_camera) return std::make_unique<SimulatedStation>(rig);
  return std::make_unique<DeviceStation>(
      std::make_unique<Gphoto2Camera>(CameraChoice{rig.camera_port, rig.camera_model}), MakeWheel(rig, ask));
}

}  // namespace dermap
