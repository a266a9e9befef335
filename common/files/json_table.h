// SPDX-License-Identifier: Apache-2.0
// A JSON file read with the same checks as TOML configuration.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/files/toml_table.h"

namespace dermap {

// The object in a JSON file; throws InputError where it is not JSON or not an object.
TomlTable ReadJsonTable(const std::filesystem::path& path);

// An object at hand; `where` stands where the file's name would.
TomlTable ToTable(const nlohmann::json& json, const std::string& where);

}  // namespace dermap
