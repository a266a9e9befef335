// SPDX-License-Identifier: Apache-2.0
// The wheel echoes a command, prints its value if it has one, then its prompt "> ". Lines end with CR. The
// bridge leads every packet of 64 bytes with two of status, and passes noise unless the line is set to 115200
// 8N1. That a move's prompt comes once the wheel stands, and that commands wait for it, is assumed, as is
// that it is an FTDI.
#include "acquire/emulator/thorlabs_wheel.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>

namespace dermap::emulator {
namespace {

constexpr std::uint8_t kDataIn = 0x81, kDataOut = 0x02;
constexpr std::size_t kPayload = 62;
constexpr std::uint8_t kStatus[2]{0x01, 0x60};
constexpr unsigned kBaud115200 = 0x1A, k8N1 = 8;

}  // namespace

UsbIdentity ThorlabsWheel::Identity() const {
  return {.vendor = 0x0403,
          .product = 0x6001,
          .manufacturer = "Thorlabs",
          .name = motion_.slot_count() == 12 ? "FW212C" : "FW102C",
          .serial = "TP00000001",
          .endpoints = {{kDataIn, 2, 64}, {kDataOut, 2, 64}},
          .speed_mbit_s = 12};
}

int ThorlabsWheel::Control(const UsbSetup& setup, std::span<const std::uint8_t>, Bytes&) {
  if (setup.request_type != 0x40) return -EPIPE;
  switch (setup.request) {
    case 0:  // reset; 1 and 2 empty the buffers
      line_.clear();
      waiting_.clear();
      owes_prompt_ = false;
      DropAnswers(kDataIn);
      return 0;
    case 2:
      return 0;
    case 3:
      baud_divisor_ = setup.value;
      return 0;
    case 4:
      data_format_ = setup.value;
      return 0;
    case 9:
      latency_ = std::chrono::milliseconds(std::clamp<int>(setup.value, 1, 255));
      return 0;
    default:
      return -EPIPE;
  }
}

int ThorlabsWheel::Out(std::uint8_t endpoint, std::span<const std::uint8_t> data) {
  if (endpoint != kDataOut) return -EPIPE;
  if (silent) return 0;
  const bool noise = baud_divisor_ != kBaud115200 || data_format_ != k8N1;
  for (const std::uint8_t byte : data) {
    const char c = static_cast<char>(noise ? byte ^ 0xA5 : byte);
    if (c == '\r') {
      waiting_.push_back(line_);
      line_.clear();
    } else {
      line_ += c;
    }
  }
  ObeyWaiting();
  return 0;
}

std::optional<UsbDevice::Idle> ThorlabsWheel::WhenIdle(std::uint8_t endpoint) {
  if (endpoint != kDataIn) return std::nullopt;
  ObeyWaiting();
  return Idle{{kStatus[0], kStatus[1]}, latency_};
}

void ThorlabsWheel::ObeyWaiting() {
  while (motion_.Reported() != 0 && (owes_prompt_ || !waiting_.empty())) {
    if (owes_prompt_) {
      owes_prompt_ = false;
      Say("> ");
      continue;
    }
    const std::string command = waiting_.front();
    waiting_.pop_front();
    Obey(command);
  }
}

void ThorlabsWheel::Say(const std::string& text) {
  for (std::size_t at = 0; at < text.size(); at += kPayload) {
    Bytes packet{kStatus[0], kStatus[1]};
    const std::string piece = text.substr(at, kPayload);
    packet.insert(packet.end(), piece.begin(), piece.end());
    Answer(kDataIn, std::move(packet));
  }
}

void ThorlabsWheel::Obey(const std::string& command) {
  const std::string echo = command + "\r", prompt = "> ";
  if (command.empty()) return Say("\r" + prompt);
  if (command == "*idn?") {
    return Say(echo + "THORLABS " + (motion_.slot_count() == 12 ? "FW212C" : "FW102C") +
               "/FW212C Filter Wheel version 1.07\r" + prompt);
  }
  if (command == "pcount?") return Say(echo + std::to_string(motion_.slot_count()) + "\r" + prompt);
  if (command == "pos?") return Say(echo + std::to_string(motion_.Reported()) + "\r" + prompt);
  if (command.rfind("pos=", 0) == 0) {
    const int slot = std::atoi(command.c_str() + 4);
    if (slot < 1 || slot > motion_.slot_count())
      return Say(echo + "Command error CMD_ARG_INVALID\r" + prompt);
    motion_.MoveTo(slot);
    owes_prompt_ = true;
    return Say(echo);
  }
  if (command == "speed=1" || command == "speed=0" || command == "sensors=0" || command == "sensors=1") {
    return Say(echo + prompt);
  }
  Say(echo + "Command error CMD_NOT_DEFINED\r" + prompt);
}

}  // namespace dermap::emulator
