// SPDX-License-Identifier: Apache-2.0
// Finds config/ for a program that is installed, in its build folder, or elsewhere.
#include <spdlog/fmt/fmt.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "common/core/error.h"
#include "common/tissue/tissue.h"

namespace dermap {

std::filesystem::path ConfigDirectory() {
  namespace fs = std::filesystem;
  // What every configuration folder holds; a folder of that name alone proves nothing.
  const auto has_spectra = [](const fs::path& directory) {
    std::error_code ignored;
    return fs::is_directory(directory / "spectra", ignored);
  };
  if (const char* chosen = std::getenv("DERMAP_CONFIG_DIR"); chosen != nullptr && *chosen != '\0') {
    if (has_spectra(chosen)) return chosen;
    throw InputError(fmt::format(
        "DERMAP_CONFIG_DIR is '{}', which has no folder 'spectra'; let it name dermap's config folder.",
        chosen));
  }
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    for (const char* relative : {"../share/dermap/config", "../../../config"}) {
      const auto directory = (executable.parent_path() / relative).lexically_normal();
      if (has_spectra(directory)) return directory;
    }
  }
  if (has_spectra(DERMAP_SOURCE_CONFIG_DIR)) return DERMAP_SOURCE_CONFIG_DIR;
  throw InputError(
      fmt::format("No config folder was found beside {} or at {}; let the environment variable "
                  "DERMAP_CONFIG_DIR name it.",
                  executable.string(), DERMAP_SOURCE_CONFIG_DIR));
}

}  // namespace dermap
