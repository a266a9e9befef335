// SPDX-License-Identifier: Apache-2.0
// {0x80 + slot, 0} moves, {0, 0} asks, {0, 1} counts slots and calibrates; the answer is {slot, or 0 while it
// moves; how many}. That reports come by SET_REPORT and go by the interrupt endpoint is assumed.
#include "acquire/emulator/starlight_wheel.h"

#include <cerrno>

namespace dermap::emulator {
namespace {

constexpr std::uint8_t kReportsIn = 0x81;
constexpr std::uint8_t kSetReport = 9;
constexpr std::uint8_t kMove = 0x80;

}  // namespace

UsbIdentity StarlightWheel::Identity() const {
  return {.vendor = 0x1278,
          .product = 0x0920,
          .manufacturer = "Starlight Xpress",
          .name = "SX filter wheel",
          .serial = "",
          .interface_class = 3,
          .endpoints = {{kReportsIn, 3, 2}},
          .speed_mbit_s = 12};
}

int StarlightWheel::Control(const UsbSetup& setup, std::span<const std::uint8_t> out, Bytes&) {
  if (setup.request_type != 0x21 || setup.request != kSetReport || out.size() != 2) return -EPIPE;
  if (silent) return 0;
  const int slot = out[0] - kMove;
  if (slot >= 1 && slot <= motion_.slot_count()) {
    motion_.MoveTo(slot);
  } else if (out[0] == 0 && out[1] == 1) {
    motion_.Home();
  } else if (out[0] != 0) {
    return 0;  // a slot that it does not have: it answers nothing
  }
  Answer(kReportsIn,
         {static_cast<std::uint8_t>(motion_.Reported()), static_cast<std::uint8_t>(motion_.slot_count())});
  return 0;
}

}  // namespace dermap::emulator
