// SPDX-License-Identifier: Apache-2.0
// Asking the person at the terminal.
#pragma once

#include <functional>

#include "acquire/devices/operator.h"

namespace dermap {

// Prints the request on standard error, what it is about in brackets, and waits for Enter on standard input.
// Says no once `stop` is true, or where input ends.
AskOperator AskOnTerminal(std::function<bool()> stop);

}  // namespace dermap
