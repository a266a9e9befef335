// SPDX-License-Identifier: Apache-2.0
// What a Thorlabs wheel's bytes say: packets of its FTDI bridge to text, text to answers.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace dermap {

// What a packet holds behind the bridge's two status bytes.
std::string PayloadOfPacket(std::span<const std::uint8_t> packet);
// Whether the wheel has come to its prompt "> ".
bool EndsWithPrompt(const std::string& text);
// What it printed between the echo of `command` and the prompt. Throws DeviceFault where it is an error.
std::string ThorlabsAnswer(const std::string& wheel, const std::string& command, std::string text);
// Throws DeviceFault where that is not what a FW102C or FW212C answers to `*idn?`.
void RequireThorlabsWheel(const std::string& identity);
// A slot or a count: 1 to 64. Throws DeviceFault where it is none.
int ThorlabsNumber(const std::string& wheel, const std::string& answer);

}  // namespace dermap
