// SPDX-License-Identifier: Apache-2.0
// truth/ of a simulated session: what the frames were made from, for whoever judges what is made of them.
#pragma once

#include <filesystem>
#include <span>

#include "acquire/simulated/optical_bench.h"
#include "common/files/session.h"

namespace dermap {

// DIR/maps.exr (unless a test pattern stands in place of skin), DIR/reflectance.exr (through the filters) and
// DIR/bench.json (seed, every effect's strength, and flash, pose and window corners of each frame of the
// schedule).
void WriteTruth(const std::filesystem::path& directory, const OpticalBench& bench,
                std::span<const FrameRecord> schedule);

}  // namespace dermap
