// SPDX-License-Identifier: Apache-2.0
// Tables as comma-separated text, every row with the line that it stands on.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace dermap {

struct CsvRow {
  std::size_t line = 0;  // of the file, from 1
  std::vector<std::string> fields;
};

struct CsvTable {
  CsvRow header;
  std::vector<CsvRow> rows;  // each with as many fields as the header
};

// UTF-8 (a byte order mark is skipped), lines ending in LF or CRLF; empty lines and lines that begin with #
// are comments. A field may stand in double quotes, "" in it is one; spaces around fields are dropped. Throws
// InputError that names file and line for a row with too few or too many fields, a quote that is not closed,
// and bytes that are no text.
CsvTable ReadCsv(const std::filesystem::path& path);

// A field as it is written, in quotes where it needs them.
std::string CsvField(std::string_view text);

// The whole text as a finite decimal number. Throws InputError that begins with `where` and names `what`.
double CsvNumber(std::string_view where, std::string_view what, std::string_view text);

}  // namespace dermap
