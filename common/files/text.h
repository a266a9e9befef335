// SPDX-License-Identifier: Apache-2.0
// Within this folder: small helpers for names and messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dermap {

// The shortest text that reads back as the same number: 0.1, 1e+20.
std::string FormatNumber(double value);

// The decimal number that a float32 was most likely rounded from: 0.1f becomes 0.1, not 0.100000001490116.
double DecimalOf(float value);

// At most `length` bytes of it on one line, with "..." where something was left out.
std::string Shorten(std::string_view text, std::size_t length);

// Changes, insertions, deletions and swaps of neighbours that turn one into the other.
std::size_t EditDistance(std::string_view a, std::string_view b);

std::string_view Trim(std::string_view text);
std::string LowerCase(std::string_view text);  // ASCII

template <class Range>
std::string Join(const Range& words, std::string_view separator) {
  std::string joined;
  for (const auto& word : words) {
    if (!joined.empty()) joined += separator;
    joined += word;
  }
  return joined;
}

}  // namespace dermap
