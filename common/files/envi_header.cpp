// SPDX-License-Identifier: Apache-2.0
// ENVI headers: "ENVI", then KEY = VALUE lines; a value in braces may go on over several lines.
#include "common/files/envi_header.h"

#include <charconv>
#include <cmath>
#include <sstream>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/text.h"

namespace dermap {
namespace {

std::optional<double> ParseNumber(std::string_view text) {
  text = Trim(text);
  if (text.starts_with("+")) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

}  // namespace

EnviHeader EnviHeader::Read(const std::filesystem::path& path) {
  EnviHeader header;
  header.file_ = path.string();
  std::istringstream lines(ReadTextFile(path));
  std::string line;
  if (!std::getline(lines, line) || Trim(line) != "ENVI") {
    throw InputError(header.file_ + " is not an ENVI header; expected a first line that says ENVI");
  }
  for (int number = 2; std::getline(lines, line); ++number) {
    if (Trim(line).empty() || Trim(line).starts_with(";")) continue;
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) {
      throw InputError(header.file_ + " line " + std::to_string(number) + ": \"" + Shorten(Trim(line), 60) +
                       "\"; expected KEY = VALUE");
    }
    const std::string spelled(Trim(std::string_view(line).substr(0, equals)));
    std::string value(Trim(std::string_view(line).substr(equals + 1)));
    const int first = number;
    while (value.starts_with("{") && value.find('}') == std::string::npos) {
      if (!std::getline(lines, line)) {
        throw InputError(header.file_ + " line " + std::to_string(first) + ": the brace of '" +
                         Shorten(spelled, 60) + "' is never closed; the file is incomplete, or add the '}'");
      }
      ++number;
      value += "\n" + line;
    }
    header.entries_[LowerCase(spelled)] = {spelled, std::string(Trim(value))};
  }
  return header;
}

std::optional<std::string> EnviHeader::Text(const std::string& key) const {
  const auto found = entries_.find(key);
  if (found == entries_.end()) return std::nullopt;
  return found->second.value;
}

std::optional<double> EnviHeader::Number(const std::string& key) const {
  const auto text = Text(key);
  if (!text) return std::nullopt;
  const auto number = ParseNumber(*text);
  if (!number) {
    throw InputError(file_ + ": '" + key + "' is \"" + Shorten(*text, 40) + "\"; expected a finite number");
  }
  return number;
}

std::optional<std::vector<double>> EnviHeader::Numbers(const std::string& key) const {
  const auto text = Text(key);
  if (!text) return std::nullopt;
  const std::string expected = "; expected a list of numbers such as {450, 480}";
  if (!text->starts_with("{") || !text->ends_with("}")) {
    throw InputError(file_ + ": '" + key + "' is \"" + Shorten(*text, 40) + "\"" + expected);
  }
  std::vector<double> numbers;
  std::istringstream items(text->substr(1, text->size() - 2));
  for (std::string item; std::getline(items, item, ',');) {
    const auto number = ParseNumber(item);
    if (!number) {
      throw InputError(file_ + ": '" + key + "' holds \"" + Shorten(Trim(item), 40) + "\"" + expected);
    }
    numbers.push_back(*number);
  }
  return numbers;
}

long long EnviHeader::Integer(const std::string& key, long long fallback, long long lower,
                              long long upper) const {
  const auto number = Number(key);
  if (!number) return fallback;
  if (*number != std::floor(*number) || *number < static_cast<double>(lower) ||
      *number > static_cast<double>(upper)) {
    throw InputError(file_ + ": '" + key + "' is " + FormatNumber(*number) + "; expected an integer from " +
                     std::to_string(lower) + " to " + std::to_string(upper));
  }
  return static_cast<long long>(*number);
}

long long EnviHeader::RequiredInteger(const std::string& key, long long lower, long long upper) const {
  if (!entries_.contains(key)) {
    throw InputError(file_ + ": the key '" + key + "' is missing; expected an integer from " +
                     std::to_string(lower) + " to " + std::to_string(upper));
  }
  return Integer(key, 0, lower, upper);
}

std::map<std::string, std::string> EnviHeader::WithPrefix(const std::string& prefix) const {
  std::map<std::string, std::string> found;
  for (const auto& [key, entry] : entries_) {
    if (key.starts_with(prefix)) found[entry.spelled.substr(prefix.size())] = entry.value;
  }
  return found;
}

}  // namespace dermap
