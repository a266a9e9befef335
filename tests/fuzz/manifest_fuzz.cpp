// SPDX-License-Identifier: Apache-2.0
// Any bytes as session.json, and as the TOML that says which file is what: a session, or an InputError.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "calibrate/folder_session.h"
#include "common/core/error.h"
#include "common/files/session.h"

namespace {

const std::filesystem::path& Folder() {
  static const std::filesystem::path folder = [] {
    auto path = std::filesystem::temp_directory_path() / ("dermap_fuzz_" + std::to_string(getpid()));
    std::filesystem::create_directories(path);
    return path;
  }();
  return folder;
}

template <class Read>
void Try(const std::string& name, const std::uint8_t* data, std::size_t size, const Read& read) {
  std::ofstream(Folder() / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    read();
  } catch (const dermap::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Try("session.json", data, size, [] { dermap::ReadSession(Folder()); });
  Try("files.toml", data, size, [] { dermap::ReadFolderSession(Folder() / "files.toml"); });
  return 0;
}
