// SPDX-License-Identifier: Apache-2.0
// Other people's recordings: raw files in a folder, with a small TOML that says which file is what.
#pragma once

#include <filesystem>

#include "common/files/session.h"

namespace dermap {

// Keys in docs/formats.md. Exposure and ISO are read from the raw files where the TOML does not say. Throws
// InputError.
Session ReadFolderSession(const std::filesystem::path& files_toml);

}  // namespace dermap
