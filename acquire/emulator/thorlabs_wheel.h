// SPDX-License-Identifier: Apache-2.0
// A Thorlabs FW102C or FW212C behind its FTDI bridge (0403:6001).
#pragma once

#include <deque>
#include <string>

#include "acquire/emulator/usb_device.h"
#include "acquire/emulator/wheel_motion.h"

namespace dermap::emulator {

class ThorlabsWheel : public UsbDevice {
 public:
  explicit ThorlabsWheel(WheelMotion& motion) : motion_(motion) {}
  UsbIdentity Identity() const override;
  int Control(const UsbSetup& setup, std::span<const std::uint8_t> out, Bytes& in) override;
  int Out(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  std::optional<Idle> WhenIdle(std::uint8_t endpoint) override;

  bool silent = false;

 private:
  void Obey(const std::string& command);
  void Say(const std::string& text);
  WheelMotion& motion_;
  void ObeyWaiting();  // commands that came while the wheel turned
  std::string line_;
  std::deque<std::string> waiting_;
  bool owes_prompt_ = false;  // of a move
  unsigned baud_divisor_ = 0, data_format_ = 0;
  std::chrono::milliseconds latency_{16};
};

}  // namespace dermap::emulator
