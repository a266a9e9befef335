// SPDX-License-Identifier: Apache-2.0
// Runs a program on the emulated station and plays its operator: reads what it asks for, does it, presses
// Enter.
#pragma once

#include <string>
#include <vector>

#include "acquire/emulator/station.h"

namespace dermap::emulator {

// What the program prints on standard error is passed on; `answer_s` is how long the operator takes for each
// thing asked for. Returns its exit status, or 128 + signal.
int RunWithOperator(EmulatedStation& station, const std::vector<std::string>& command, double answer_s);

}  // namespace dermap::emulator
