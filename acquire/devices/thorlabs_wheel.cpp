// SPDX-License-Identifier: Apache-2.0
// The driver "thorlabs": FW102C and FW212C. ASCII lines that end with CR at 115200 8N1; the wheel echoes a
// command, prints its value, then the prompt "> ". The bridge is assumed to be an FTDI: OpenLine, WriteBytes
// and ReadBytes are the only places that know.
#include <algorithm>
#include <array>

#include "acquire/devices/device_fault.h"
#include "acquire/devices/thorlabs_answer.h"
#include "acquire/devices/usb_wheel.h"

namespace dermap {
namespace {

using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

constexpr std::uint8_t kDataOut = 0x02, kDataIn = 0x81, kVendorOut = 0x40;
constexpr std::size_t kPacket = 64;
constexpr std::size_t kLongestAnswer = 4096;
constexpr std::uint16_t kBaud115200 = 0x1A, k8N1 = 8, kLatency_ms = 2;

class Thorlabs : public WheelProtocol {
 public:
  explicit Thorlabs(std::string serial) : serial_(std::move(serial)) {}
  std::string Name() const override { return "Thorlabs wheel"; }
  UsbId Id() const override { return {0x0403, 0x6001, serial_}; }

  int Begin(UsbLink& link, const WheelTiming& timing) override {
    OpenLine(link, timing);
    RequireThorlabsWheel(Ask(link, "*idn?", timing.answer));
    return count_ = Number(Ask(link, "pcount?", timing.answer));
  }
  bool BeginFindsSlots() const override { return false; }  // it has no command for it
  void StartMove(UsbLink& link, int slot, const WheelTiming& timing) override {
    // The prompt comes once it stands: the time of a whole turn.
    const auto limit = timing.answer + count_ * timing.per_slot;
    Ask(link, "pos=" + std::to_string(slot), limit, FaultKind::kStuck);
  }
  int Position(UsbLink& link, const WheelTiming& timing) override {
    return Number(Ask(link, "pos?", timing.answer));
  }

 private:
  static void OpenLine(UsbLink& link, const WheelTiming& timing) {
    for (const std::uint16_t reset : {0, 1, 2}) link.Control({kVendorOut, 0, reset, 0}, {}, timing.answer);
    link.Control({kVendorOut, 3, kBaud115200, 0}, {}, timing.answer);
    link.Control({kVendorOut, 4, k8N1, 0}, {}, timing.answer);
    link.Control({kVendorOut, 2, 0, 0}, {}, timing.answer);
    link.Control({kVendorOut, 9, kLatency_ms, 0}, {}, timing.answer);
  }
  static void WriteBytes(UsbLink& link, const std::string& text, milliseconds limit) {
    link.Write(kDataOut, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, limit);
  }
  static std::string ReadBytes(UsbLink& link, milliseconds limit) {
    std::array<std::uint8_t, kPacket> packet{};
    const std::size_t size = link.Read(kDataIn, false, packet, limit);
    return PayloadOfPacket({packet.data(), size});
  }

  // What the wheel prints between the echo and the prompt.
  std::string Ask(UsbLink& link, const std::string& command, milliseconds limit,
                  FaultKind when_silent = FaultKind::kNoAnswer) const {
    WriteBytes(link, command + "\r", limit);
    const auto until = SteadyClock::now() + limit;
    std::string text;
    while (!EndsWithPrompt(text) && text.size() < kLongestAnswer && SteadyClock::now() < until) {
      text += ReadBytes(link, std::min<milliseconds>(limit, milliseconds(100)));
    }
    if (!EndsWithPrompt(text)) {
      throw DeviceFault(when_silent, Name() + " does not come to an end with '" + command +
                                         "'; remedy: see whether a filter blocks it, switch it off and on");
    }
    return ThorlabsAnswer(Name(), command, text);
  }
  int Number(const std::string& text) const { return ThorlabsNumber(Name(), text); }

  std::string serial_;
  int count_ = 6;
};

}  // namespace

std::unique_ptr<FilterWheel> MakeThorlabsWheel(const std::string& serial, const WheelTiming& timing) {
  return std::make_unique<UsbWheel>(std::make_unique<Thorlabs>(serial), timing);
}

}  // namespace dermap
