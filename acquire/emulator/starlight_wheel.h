// SPDX-License-Identifier: Apache-2.0
// A Starlight Xpress filter wheel on USB (HID 1278:0920): two-byte reports.
#pragma once

#include "acquire/emulator/usb_device.h"
#include "acquire/emulator/wheel_motion.h"

namespace dermap::emulator {

class StarlightWheel : public UsbDevice {
 public:
  explicit StarlightWheel(WheelMotion& motion) : motion_(motion) {}
  UsbIdentity Identity() const override;
  int Control(const UsbSetup& setup, std::span<const std::uint8_t> out, Bytes& in) override;
  int Out(std::uint8_t, std::span<const std::uint8_t>) override { return -32; }

  bool silent = false;  // takes reports and answers none

 private:
  WheelMotion& motion_;
};

}  // namespace dermap::emulator
