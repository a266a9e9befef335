// SPDX-License-Identifier: Apache-2.0
// PTP over USB (still image capture class): containers on two bulk endpoints.
#pragma once

#include <optional>

#include "acquire/emulator/eos_camera.h"
#include "acquire/emulator/usb_device.h"

namespace dermap::emulator {

class PtpUsb : public UsbDevice {
 public:
  explicit PtpUsb(EosCamera& camera) : camera_(camera) {}
  UsbIdentity Identity() const override;
  int Control(const UsbSetup& setup, std::span<const std::uint8_t> out, Bytes& in) override;
  int Out(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  int InState(std::uint8_t endpoint) override;
  void ClearHalt(std::uint8_t endpoint) override;
  void Detached() override;

 private:
  void Reset();
  void Run(const PtpRequest& request);
  EosCamera& camera_;
  Bytes arrived_;                    // of a container that is not whole yet
  std::optional<PtpRequest> begun_;  // waits for its data
};

}  // namespace dermap::emulator
