// SPDX-License-Identifier: Apache-2.0
// Any bytes as journal.jsonl: events whose frames and changes can be read, or an InputError.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/files/session.h"
#include "common/files/session_journal.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto path =
      std::filesystem::temp_directory_path() / ("dermap_journal_" + std::to_string(getpid()) + ".jsonl");
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    for (const auto& event : dermap::ReadJournal(path)) {
      if (event.contains("frame")) dermap::FrameFromJson(event["frame"], path.string());
      if (event.contains("change")) dermap::ExposureChangeFromJson(event["change"], path.string());
    }
  } catch (const dermap::InputError&) {
  }
  return 0;
}
