// SPDX-License-Identifier: Apache-2.0
// Raw files on which LibRaw itself may end the program: asked before LibRaw opens any.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace dermap {

// False where opening the file by LibRaw ends a process. LibRaw 0.20 overruns a buffer in parseHassyModel on
// damaged files of that maker, and libc then aborts: files that name it are opened in a child process first.
// Costs nothing for others.
bool SurvivesLibRaw(const std::filesystem::path& path);
// The same of a file that is in memory.
bool SurvivesLibRaw(std::span<const std::byte> file);

}  // namespace dermap
