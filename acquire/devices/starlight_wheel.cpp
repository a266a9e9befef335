// SPDX-License-Identifier: Apache-2.0
// The driver "starlight": Starlight Xpress wheels, HID, two-byte reports. {0x80 + slot, 0} moves, {0, 0}
// asks, {0, 1} counts slots and calibrates; the answer is {slot, or 0 while it moves; how many}. That reports
// go out by SET_REPORT and come in by interrupt is assumed: SendReport and ReadReport are the only places
// that know.
#include <array>

#include "acquire/devices/device_fault.h"
#include "acquire/devices/usb_wheel.h"

namespace dermap {
namespace {

using Report = std::array<std::uint8_t, 2>;
constexpr std::uint8_t kReportsIn = 0x81;
constexpr std::uint8_t kMove = 0x80;
constexpr int kMostSlots = 32;  // a count beyond it is noise

class Starlight : public WheelProtocol {
 public:
  explicit Starlight(std::string serial) : serial_(std::move(serial)) {}
  std::string Name() const override { return "Starlight Xpress wheel"; }
  UsbId Id() const override { return {0x1278, 0x0920, serial_}; }

  int Begin(UsbLink& link, const WheelTiming& timing) override {
    Forget(link);
    const int count = Ask(link, {0, 1}, timing)[1];
    if (count >= 1 && count <= kMostSlots) return count;
    throw DeviceFault(FaultKind::kNoAnswer, Name() + " says that it has " + std::to_string(count) +
                                                " slots; remedy: switch it off and on");
  }
  bool BeginFindsSlots() const override { return true; }
  void StartMove(UsbLink& link, int slot, const WheelTiming& timing) override {
    Forget(link);
    Ask(link, {static_cast<std::uint8_t>(kMove + slot), 0}, timing);
  }
  int Position(UsbLink& link, const WheelTiming& timing) override { return Ask(link, {0, 0}, timing)[0]; }

 private:
  static void SendReport(UsbLink& link, const Report& report, const WheelTiming& timing) {
    link.Control({0x21, 9, 0x0200, 0}, report, timing.answer);
  }
  static std::size_t ReadReport(UsbLink& link, Report& report, std::chrono::milliseconds limit) {
    return link.Read(kReportsIn, true, report, limit);
  }
  // Answers to questions of an earlier connection.
  static void Forget(UsbLink& link) {
    Report stale;
    while (ReadReport(link, stale, std::chrono::milliseconds(2)) != 0) {
    }
  }
  Report Ask(UsbLink& link, const Report& question, const WheelTiming& timing) const {
    Report answer{};
    SendReport(link, question, timing);
    if (ReadReport(link, answer, timing.answer) == answer.size()) return answer;
    throw DeviceFault(FaultKind::kNoAnswer,
                      Name() + " does not answer; remedy: switch it off and on, and check its cable");
  }

  std::string serial_;
};

}  // namespace

std::unique_ptr<FilterWheel> MakeStarlightWheel(const std::string& serial, const WheelTiming& timing) {
  return std::make_unique<UsbWheel>(std::make_unique<Starlight>(serial), timing);
}

}  // namespace dermap
