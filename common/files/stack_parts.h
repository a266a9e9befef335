// SPDX-License-Identifier: Apache-2.0
// Within this folder: what the readers of both stack formats share, and the formats' entry points.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/files/spectral_attributes.h"
#include "common/files/stack.h"

namespace dermap {

struct BandPlanes {
  Band band;
  PlaneF reflectance;
  PlaneF sigma;  // empty where the file has none
};

// Sorts the bands, checks every value of theirs and of `valid`, and makes the stack. Throws InputError.
ReflectanceStack AssembleStack(const std::string& file, std::vector<BandPlanes> bands, PlaneF valid,
                               const FileConditions& conditions);
FileConditions ConditionsOf(const ReflectanceStack& stack);

ReflectanceStack ReadExrStack(const std::filesystem::path& path);
void WriteExrStack(const std::filesystem::path& path, const ReflectanceStack& stack);
ReflectanceStack ReadEnviStack(const std::filesystem::path& path);
void WriteEnviStack(const std::filesystem::path& path, const ReflectanceStack& stack);

}  // namespace dermap
