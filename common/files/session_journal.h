// SPDX-License-Identifier: Apache-2.0
// journal.jsonl: what happened in a session, one JSON object a line, on disk before the next step begins.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace dermap {

// Appends lines. One process at a time may hold a journal open; a second gets an InputError. Opening drops a
// torn last line (power cut, full disk), since what it told of was never confirmed.
class Journal {
 public:
  explicit Journal(const std::filesystem::path& path);
  ~Journal();
  Journal(Journal&&) noexcept;

  // Returns once the line is on disk; throws StorageError, and then the journal ends with the line before.
  void Append(const nlohmann::json& event);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// All whole lines; a torn last one is left out. A missing file is an empty journal. Throws InputError, naming
// the line, where any other line is not a JSON object.
std::vector<nlohmann::json> ReadJournal(const std::filesystem::path& path);

}  // namespace dermap
