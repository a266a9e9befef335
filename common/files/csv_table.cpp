// SPDX-License-Identifier: Apache-2.0
// Reads comma-separated text line by line.
#include "common/files/csv_table.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string Where(const std::filesystem::path& path, std::size_t line) {
  return fmt::format("{} line {}", path.string(), line);
}

// What stands in quotes from text[at] on; leaves `at` behind the closing quote.
std::string Quoted(std::string_view text, std::size_t& at, const std::string& where) {
  std::string field;
  for (++at; at < text.size(); ++at) {
    if (text[at] != '"') {
      field += text[at];
    } else if (at + 1 < text.size() && text[at + 1] == '"') {
      field += text[++at];
    } else {
      ++at;
      return field;
    }
  }
  throw InputError(where + ": a quote is not closed before the line ends.");
}

std::vector<std::string> Fields(std::string_view text, const std::string& where) {
  std::vector<std::string> fields;
  std::size_t at = 0;
  while (true) {
    while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
    if (at < text.size() && text[at] == '"') {
      fields.push_back(Quoted(text, at, where));
      while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
      if (at < text.size() && text[at] != ',') {
        throw InputError(where + ": expected a comma behind the closing quote.");
      }
    } else {
      const std::size_t end = std::min(text.find(',', at), text.size());
      fields.emplace_back(Trim(text.substr(at, end - at)));
      at = end;
    }
    if (at >= text.size()) return fields;
    ++at;  // the comma
  }
}

}  // namespace

CsvTable ReadCsv(const std::filesystem::path& path) {
  const std::string contents = ReadTextFile(path);
  std::string_view left = contents;
  if (left.starts_with(kByteOrderMark)) left.remove_prefix(kByteOrderMark.size());
  CsvTable table;
  for (std::size_t line = 1; !left.empty(); ++line) {
    const std::size_t end = std::min(left.find('\n'), left.size());
    std::string_view text = left.substr(0, end);
    left.remove_prefix(std::min(end + 1, left.size()));
    if (text.ends_with('\r')) text.remove_suffix(1);
    if (text.find('\0') != std::string_view::npos) {
      throw InputError(Where(path, line) +
                       ": this is no text; expected a table with commas between its fields.");
    }
    const std::string_view trimmed = Trim(text);
    if (trimmed.empty() || trimmed.front() == '#') continue;
    CsvRow row{line, Fields(text, Where(path, line))};
    if (table.header.fields.empty()) {
      table.header = std::move(row);
      continue;
    }
    if (row.fields.size() != table.header.fields.size()) {
      throw InputError(fmt::format("{}: found {} fields, expected {}, as many as line {} has columns.",
                                   Where(path, line), row.fields.size(), table.header.fields.size(),
                                   table.header.line));
    }
    table.rows.push_back(std::move(row));
  }
  if (table.header.fields.empty()) {
    throw InputError(path.string() + " is empty; expected a line with the names of the columns.");
  }
  return table;
}

std::string CsvField(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos && Trim(text).size() == text.size()) {
    return std::string(text);
  }
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

double CsvNumber(std::string_view where, std::string_view what, std::string_view text) {
  const std::string_view digits = text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
  double value = 0.0;
  const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (failure != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) {
    throw InputError(fmt::format("{}: {} is '{}'; expected a finite number such as 0.25.", where, what,
                                 Shorten(text, 40)));
  }
  return value;
}

}  // namespace dermap
