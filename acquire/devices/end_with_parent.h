// SPDX-License-Identifier: Apache-2.0
// For a helper process that takes its requests from standard input, a pipe: it outlives whoever asks by no
// more than `last_word`, the time to end what it is at, even where that hangs.
#pragma once

#include <chrono>

namespace dermap {

// Starts a thread that waits for the pipe to be hung up, and ends the process with status 1 after
// `last_word`.
void EndWithWhoeverAsks(std::chrono::milliseconds last_word);

}  // namespace dermap
