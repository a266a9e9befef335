// SPDX-License-Identifier: Apache-2.0
// Within this folder: an ENVI header, the text file beside the data that tells their shape.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dermap {

class EnviHeader {
 public:
  // Throws InputError naming file and line.
  static EnviHeader Read(const std::filesystem::path& path);

  const std::string& file() const { return file_; }
  // Keys in lower case. Each throws InputError naming file and key.
  std::optional<std::string> Text(const std::string& key) const;
  std::optional<double> Number(const std::string& key) const;
  std::optional<std::vector<double>> Numbers(const std::string& key) const;  // {450, 480}
  long long RequiredInteger(const std::string& key, long long lower, long long upper) const;
  long long Integer(const std::string& key, long long fallback, long long lower, long long upper) const;
  // Keys that begin so, as they are spelled in the file, with what follows the prefix.
  std::map<std::string, std::string> WithPrefix(const std::string& prefix) const;

 private:
  struct Entry {
    std::string spelled;
    std::string value;
  };
  std::string file_;
  std::map<std::string, Entry> entries_;
};

}  // namespace dermap
