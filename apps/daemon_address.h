// SPDX-License-Identifier: Apache-2.0
// Where a daemon listens, and the token that it asks for: flags of `serve` and `capture --daemon`.
#pragma once

#include <filesystem>
#include <string>

#include "acquire/daemon/http_server.h"

namespace dermap {

// "ADDRESS:PORT"; throws InputError that names the flag.
ServerOptions ParseDaemonAddress(const std::string& flag, const std::string& text);
// The token in a file; empty where no file is named. Throws InputError where it is too short.
std::string ReadDaemonToken(const std::filesystem::path& path);

}  // namespace dermap
