// SPDX-License-Identifier: Apache-2.0
// Codes of one length are consecutive numbers [T.81 annex C], so a code is found by its length's first and
// last.
#include "calibrate/jpeg_huffman.h"

#include <algorithm>
#include <cstring>

namespace dermap {

std::vector<std::uint8_t> WithoutStuffing(std::span<const std::uint8_t> scan) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(scan.size() + kReadAtOnce);
  const std::uint8_t* from = scan.data();
  const std::uint8_t* const end = from + scan.size();
  while (from < end) {
    const void* found = std::memchr(from, 0xFF, static_cast<std::size_t>(end - from));
    const auto* ones = static_cast<const std::uint8_t*>(found);
    const bool stuffed = ones != nullptr && ones + 1 < end && ones[1] == 0;
    bytes.insert(bytes.end(), from, ones == nullptr ? end : ones + (stuffed ? 1 : 0));
    if (!stuffed) break;
    from = ones + 2;
  }
  bytes.resize(bytes.size() + kReadAtOnce);
  return bytes;
}

std::optional<HuffmanTable> HuffmanTable::FromCounts(std::span<const std::uint8_t, kLongestCode> counts,
                                                     std::span<const std::uint8_t> categories) {
  HuffmanTable table;
  std::uint32_t code = 0;
  std::size_t place = 0;
  for (int length = 1; length <= kLongestCode; ++length) {
    const auto l = static_cast<std::size_t>(length);
    const std::uint32_t after = code + counts[l - 1];
    if (after > 1U << length) return std::nullopt;
    table.first_[l] = code << (kLongestCode - length);
    table.end_[l] = after << (kLongestCode - length);
    table.place_[l] = place;
    place += counts[l - 1];
    code = after << 1U;
  }
  if (place == 0 || place > categories.size()) return std::nullopt;
  table.categories_.assign(categories.begin(), categories.begin() + static_cast<std::ptrdiff_t>(place));
  if (*std::max_element(table.categories_.begin(), table.categories_.end()) > kLargestCategory)
    return std::nullopt;
  table.FillQuick();
  return table;
}

// Length 0 where no code begins so.
HuffmanTable::Code HuffmanTable::CodeOf(std::uint32_t next_16_bits) const {
  for (int length = 1; length <= kLongestCode; ++length) {
    const auto l = static_cast<std::size_t>(length);
    if (next_16_bits < first_[l] || next_16_bits >= end_[l]) continue;
    return {length, categories_[place_[l] + ((next_16_bits - first_[l]) >> (kLongestCode - length))]};
  }
  return {};
}

void HuffmanTable::FillQuick() {
  quick_.resize(std::size_t{1} << kQuickBits);
  for (std::uint32_t i = 0; i < quick_.size(); ++i) {
    const Code code = CodeOf(i << (kLongestCode - kQuickBits));
    const int length = code.length + BitsOf(code.category);
    if (code.length == 0 || length > kQuickBits) continue;
    const std::uint32_t bits = (i >> (kQuickBits - length)) & ((1U << BitsOf(code.category)) - 1U);
    quick_[i] = {Extended(bits, code.category), static_cast<std::uint8_t>(length)};
  }
}

}  // namespace dermap
