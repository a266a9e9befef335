// SPDX-License-Identifier: Apache-2.0
// What is asked of raw files beside what LibRaw asks: those on which it may end the program itself, before it
// opens any, and sizes that no sensor has.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace dermap {

inline constexpr unsigned kMostRawMemory_mb = 1024;  // for LibRaw's max_raw_memory_mb

struct RawSizes {  // photosites: of the active area, of the sensor, and where in it the area begins
  int width = 0, height = 0;
  int raw_width = 0, raw_height = 0;
  int left = 0, top = 0;
};
// Why these are no sizes of a sensor and its active area; empty where they are.
std::string RawSizeProblem(const RawSizes& sizes);

// False where opening the file by LibRaw ends a process. LibRaw 0.20 overruns a buffer in parseHassyModel on
// damaged files of that maker, and libc then aborts: files that name it are opened in a child process first.
// Costs nothing for others.
bool SurvivesLibRaw(const std::filesystem::path& path);
// The same of a file that is in memory.
bool SurvivesLibRaw(std::span<const std::byte> file);

}  // namespace dermap
