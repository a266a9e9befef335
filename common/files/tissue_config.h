// SPDX-License-Identifier: Apache-2.0
// The [tissue] table of `--config FILE.toml` for fit, render and optics.
#pragma once

#include <filesystem>

#include "common/files/toml_table.h"
#include "common/tissue/tissue.h"

namespace dermap {

// Reads [tissue] out of an open table (scene files have one as well); what is absent keeps its default.
TissueConfig ReadTissueTable(TomlTable& file, const TissueConfig& defaults = {});
// A file with nothing but [tissue]; an unknown key or table is an error.
TissueConfig ReadTissueConfig(const std::filesystem::path& path, const TissueConfig& defaults = {});

}  // namespace dermap
