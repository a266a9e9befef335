// SPDX-License-Identifier: Apache-2.0
// Files on which LibRaw itself may end the program.
#pragma once

#include <filesystem>

namespace dermap {

// False where opening the file by LibRaw ends a process. LibRaw 0.20 overruns a buffer in parseHassyModel on
// damaged files of that maker, and libc then aborts: files that name it are opened in a child process first.
// Costs nothing for others.
bool SurvivesLibRaw(const std::filesystem::path& path);

}  // namespace dermap
