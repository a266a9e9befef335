// SPDX-License-Identifier: Apache-2.0
// Any bytes as what devices on USB say and hear: a Thorlabs wheel's packets and the camera's helper by the
// drivers; PTP containers, HID reports and FTDI bytes by the emulated devices. The first byte chooses.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "acquire/devices/camera_helper.h"
#include "acquire/devices/device_fault.h"
#include "acquire/devices/thorlabs_answer.h"
#include "acquire/emulator/ptp_usb.h"
#include "acquire/emulator/starlight_wheel.h"
#include "acquire/emulator/thorlabs_wheel.h"

namespace {

using dermap::emulator::Bytes;
using Input = std::span<const std::uint8_t>;

void ReadPackets(Input input) {
  std::string text;
  for (std::size_t at = 0; at < input.size(); at += 64)
    text += dermap::PayloadOfPacket(input.subspan(at, std::min<std::size_t>(64, input.size() - at)));
  try {
    const int number = dermap::ThorlabsNumber("wheel", dermap::ThorlabsAnswer("wheel", "pos?", text));
    if (number < 1 || number > 64) std::abort();
  } catch (const dermap::DeviceFault&) {
  }
  try {
    dermap::RequireThorlabsWheel(text);
  } catch (const dermap::DeviceFault&) {
  }
}

// What the process that libgphoto2 runs in says.
void ReadHelper(Input input) {
  const dermap::CameraAnswer answer{{input.begin(), input.end()}, {}};
  if (answer.Says("ok") && answer.Number("code", 0) == 0) answer.Text("what");
  for (const char* key : {"model", "folder", "name"}) {
    if (dermap::FrameExtension(answer.Text(key)).size() > 5) std::abort();
  }
}

void SendContainers(Input input) {
  dermap::emulator::EosCamera eos([](double, int) { return [] { return Bytes(100, 1); }; }, {});
  dermap::emulator::PtpUsb usb(eos);
  // In two transfers, so that containers come in pieces.
  usb.Out(0x02, input.first(input.size() / 2));
  usb.Out(0x02, input.subspan(input.size() / 2));
}

void SendReports(Input input) {
  dermap::emulator::WheelMotion motion(9, 0.0);
  dermap::emulator::StarlightWheel wheel(motion);
  Bytes in;
  for (std::size_t at = 0; at + 2 <= input.size(); at += 2)
    wheel.Control({0x21, 9, 0x0200, 0, 2}, input.subspan(at, 2), in);
  if (motion.InTheLight() < 0 || motion.InTheLight() > 9) std::abort();
}

void SendText(Input input) {
  dermap::emulator::WheelMotion motion(9, 0.0);
  dermap::emulator::ThorlabsWheel wheel(motion);
  Bytes in;
  wheel.Control({0x40, 3, 0x1A, 0, 0}, {}, in);
  wheel.Control({0x40, 4, 8, 0, 0}, {}, in);
  wheel.Out(0x02, input);
  wheel.WhenIdle(0x81);
  if (motion.InTheLight() < 0 || motion.InTheLight() > 9) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Input input(data + 1, size - 1);
  switch (data[0] % 5) {
    case 0:
      ReadPackets(input);
      break;
    case 1:
      SendContainers(input);
      break;
    case 2:
      SendReports(input);
      break;
    case 3:
      SendText(input);
      break;
    default:
      ReadHelper(input);
  }
  return 0;
}
