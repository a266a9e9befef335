// SPDX-License-Identifier: Apache-2.0
// Lines end with CR; the last one is the prompt.
#include "acquire/devices/thorlabs_answer.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "acquire/devices/device_fault.h"

namespace dermap {
namespace {

constexpr std::size_t kStatusBytes = 2, kPromptBytes = 2, kMostDigits = 3;

// Bytes of a confused device must not reach a terminal.
std::string Printable(const std::string& text, std::size_t most) {
  std::string shown = text.substr(0, most);
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
  return shown;
}

}  // namespace

std::string PayloadOfPacket(std::span<const std::uint8_t> packet) {
  if (packet.size() <= kStatusBytes) return "";
  return {packet.begin() + kStatusBytes, packet.end()};
}

bool EndsWithPrompt(const std::string& text) {
  return text.ends_with("> ");
}

std::string ThorlabsAnswer(const std::string& wheel, const std::string& command, std::string text) {
  if (EndsWithPrompt(text)) text.resize(text.size() - kPromptBytes);
  if (const auto echo = text.rfind(command + "\r"); echo != std::string::npos)
    text.erase(0, echo + command.size() + 1);
  while (!text.empty() && (text.back() == '\r' || text.back() == '\n')) text.pop_back();
  if (text.find("Command error") == std::string::npos) return text;
  throw DeviceFault(FaultKind::kNoAnswer, wheel + " answers '" + Printable(text, 60) + "' to '" + command +
                                              "'; remedy: switch it off and on");
}

void RequireThorlabsWheel(const std::string& identity) {
  if (identity.find("FW102C") != std::string::npos || identity.find("FW212C") != std::string::npos) return;
  throw DeviceFault(FaultKind::kNoAnswer, "an FTDI bridge answers '" + Printable(identity, 60) +
                                              "', which is no Thorlabs FW102C or FW212C; remedy: name the "
                                              "wheel's serial number in the rig");
}

int ThorlabsNumber(const std::string& wheel, const std::string& answer) {
  const bool digits =
      !answer.empty() && answer.size() <= kMostDigits &&
      std::all_of(answer.begin(), answer.end(), [](unsigned char c) { return std::isdigit(c); });
  const int value = digits ? std::atoi(answer.c_str()) : 0;
  if (value >= 1 && value <= 64) return value;
  throw DeviceFault(FaultKind::kNoAnswer, wheel + " answers '" + Printable(answer, 40) +
                                              "' where a number is expected; remedy: switch it off and on");
}

}  // namespace dermap
