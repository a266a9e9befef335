// SPDX-License-Identifier: Apache-2.0
// Telling systemd that the daemon is ready and alive; does nothing where it was not started by one.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace dermap {

void TellServiceManager(const std::string& state);  // "READY=1", "WATCHDOG=1", "STOPPING=1"
// How often it wants to hear of us, half of its limit.
std::optional<std::chrono::milliseconds> WatchdogInterval();

}  // namespace dermap
