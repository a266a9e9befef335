// SPDX-License-Identifier: Apache-2.0
// The table of drivers.
#include "acquire/devices/station.h"

#include <algorithm>

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

}  // namespace

void Station::Prepare(const ProgressFunction&) {}
void Station::WriteRecords(const std::filesystem::path&, std::span<const FrameRecord>) {}

const std::vector<std::string>& CameraDrivers() {
  static const std::vector<std::string> kDrivers{"simulated"};
  return kDrivers;
}

const std::vector<std::string>& WheelDrivers() {
  static const std::vector<std::string> kDrivers{"simulated"};
  return kDrivers;
}

std::unique_ptr<Station> MakeStation(const RigConfig& rig) {
  RequireKnown("camera", rig.camera_driver, CameraDrivers());
  RequireKnown("wheel", rig.wheel_driver, WheelDrivers());
  return std::make_unique<SimulatedStation>(rig);
}

}  // namespace dermap
