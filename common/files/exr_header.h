// SPDX-License-Identifier: Apache-2.0
// Within this folder: a look at an OpenEXR header before the library sees it.
#pragma once

#include <filesystem>

namespace dermap {

// Throws InputError where a file is no flat single-part OpenEXR image, or where its header lies about its own
// sizes (the library allocates what a header asks for before it reads on).
void CheckExrHeader(const std::filesystem::path& path);

}  // namespace dermap
