// SPDX-License-Identifier: Apache-2.0
// A whole emulated station: camera, wheel, light, and the faults that befall them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/emulator/eos_camera.h"
#include "acquire/emulator/light_path.h"
#include "acquire/emulator/ptp_ip.h"
#include "acquire/emulator/ptp_usb.h"
#include "acquire/emulator/starlight_wheel.h"
#include "acquire/emulator/thorlabs_wheel.h"
#include "acquire/emulator/unplugger.h"
#include "acquire/emulator/usb_bus.h"

namespace dermap::emulator {

struct StationOptions {
  RigConfig rig;
  std::string wheel = "starlight";  // or "thorlabs"
  std::optional<int> network_port;  // the camera on the network in place of USB; 0: any port
  bool real_time = false;           // as slow as real devices
  std::vector<std::string> faults;  // "NAME@COUNT", "NAME@COUNT:SECONDS", "NAME@COUNT:SECONDSxTIMES"
};

class EmulatedStation {
 public:
  // Throws InputError for a fault that does not exist.
  explicit EmulatedStation(const StationOptions& options, const ProgressFunction& progress = {});
  ~EmulatedStation();

  // What an operator does.
  void Place(FrameRole role);
  void TurnWheel(int slot);
  void SeeToIt();  // frees the wheel and switches it off and on, changes the card

  int network_port() const { return network_ ? network_->port() : 0; }
  int shots();

 private:
  void PlanFault(const std::string& text);
  void BefallWheel(int move);

  struct WheelFault {
    std::string name;
    int move = 1;
    double seconds = 0.5;
  };
  WheelMotion motion_;
  LightPath light_;
  EosCamera camera_;
  PtpUsb camera_usb_;
  StarlightWheel starlight_;
  ThorlabsWheel thorlabs_;
  UsbBus bus_;  // after the devices, which must outlive their time on it
  std::vector<WheelFault> wheel_faults_;
  Unplugger unplugger_;
  std::unique_ptr<PtpIp> network_;
  UsbDevice* wheel_ = nullptr;
};

}  // namespace dermap::emulator
