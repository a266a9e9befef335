// SPDX-License-Identifier: Apache-2.0
// What is attached, which driver is for it, and why it cannot be used where it cannot.
#pragma once

#include <string>
#include <vector>

#include "acquire/devices/gphoto2_camera.h"
#include "acquire/devices/usb_link.h"

namespace dermap {

struct DeviceReport {
  std::string kind;  // "camera", "wheel"
  std::string name;
  std::string driver;  // of ours; empty: none yet
  std::string port;    // as the rig's keys take it; empty where there is nothing to say
  std::string node;    // /dev/bus/usb/001/002; empty on the network
  bool usable = false;
  bool needs_rule = false;  // the system does not let us: the udev rule is missing
  std::string holder;       // the program that has it open, and its number where we may know; empty: none
  std::string note;         // what to know or to do, a sentence; may be empty
};

struct NodeHolder {
  std::string node, program;
  int pid = 0;
};
// Which programs have nodes of the USB buses open (those that we may look into).
std::vector<NodeHolder> FindNodeHolders();

std::vector<DeviceReport> MakeDeviceReport(const std::vector<UsbFound>& usb,
                                           const std::vector<AttachedCamera>& cameras,
                                           const std::vector<NodeHolder>& holders);

}  // namespace dermap
