// SPDX-License-Identifier: Apache-2.0
// TOML configuration, read key by key with units in the names; a key nobody asked for is an error that names
// the nearest known one. toml++ stays in the .cpp file.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dermap {

struct ConfigValue;

// One table of a TOML file. Every Get marks its key as known; Finish() throws InputError for keys that nobody
// asked for.
class TomlTable {
 public:
  static TomlTable ReadFile(const std::filesystem::path& path);
  // The same checks for a table that was read from elsewhere (session.json). `value` must be a table.
  TomlTable(std::string file, std::string name, const ConfigValue& value);
  TomlTable(TomlTable&&) noexcept;
  TomlTable& operator=(TomlTable&&) noexcept;
  ~TomlTable();

  bool Has(const std::string& key) const;
  // Each throws InputError (file, line, key, what was found, what was expected). Numbers must be finite.
  double Number(const std::string& key, double fallback, double lower, double upper);
  double RequiredNumber(const std::string& key, double lower, double upper);
  int Integer(const std::string& key, int fallback, int lower, int upper);
  int RequiredInteger(const std::string& key, int lower, int upper);
  bool Boolean(const std::string& key, bool fallback);
  std::string String(const std::string& key, const std::string& fallback);
  std::string RequiredString(const std::string& key);
  std::vector<double> Numbers(const std::string& key, const std::vector<double>& fallback);
  std::optional<TomlTable> Table(const std::string& key);
  std::vector<TomlTable> Tables(const std::string& key);  // [[key]]; empty where absent

  // "FILE line 7" of a key, or of this table where the key is absent or empty: for errors that only the
  // caller can see.
  std::string Where(const std::string& key = {}) const;

  // Throws for unknown keys of this table. Call it after the last Get.
  void Finish() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dermap
