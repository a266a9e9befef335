// SPDX-License-Identifier: Apache-2.0
// Headers [T.81 B.2] and lines [T.81 H.1] of lossless JPEG.
#include "calibrate/lossless_jpeg.h"

#include <cassert>

namespace dermap {
namespace {

constexpr int kMostTables = 4;
constexpr int kFewestBits = 2, kMostBits = 16;
constexpr std::uint8_t kLeftNeighbour = 1;  // predictor [T.81 table H.1]
enum Marker : std::uint8_t {
  kLosslessHuffman = 0xC3,
  kTables = 0xC4,
  kStart = 0xD8,
  kScan = 0xDA,
  kRestartInterval = 0xDD,
};

using Bytes = std::span<const std::uint8_t>;

int TwoBytes(Bytes bytes, std::size_t at) {
  return bytes[at] << 8 | bytes[at + 1];
}

struct Component {
  std::uint8_t name = 0;
  std::uint8_t scale = 0;  // 0x11: not scaled
};

// What the segments before the scan say.
struct Header {
  JpegShape shape;
  std::array<Component, kMostTables> components;
  std::array<std::optional<HuffmanTable>, kMostTables> tables;
  std::array<std::size_t, kMostTables> table_of{};  // by component
};

// False where the segment is not as it should be, here and below.
bool ReadFrame(Bytes segment, Header& header) {
  if (segment.size() < 6) return false;
  JpegShape& shape = header.shape;
  shape = {TwoBytes(segment, 1), TwoBytes(segment, 3), segment[5], segment[0]};
  const bool known = shape.components == 1 || shape.components == 2 || shape.components == 4;
  if (!known || shape.lines == 0 || shape.columns == 0 || shape.bits < kFewestBits ||
      shape.bits > kMostBits || segment.size() < 6 + 3 * static_cast<std::size_t>(shape.components))
    return false;
  for (std::size_t c = 0; c < static_cast<std::size_t>(shape.components); ++c)
    header.components[c] = {segment[6 + 3 * c], segment[7 + 3 * c]};
  return true;
}

bool ReadTables(Bytes segment, Header& header) {
  while (!segment.empty()) {
    if (segment.size() < 1 + kLongestCode || segment[0] >= kMostTables) return false;
    const auto counts = segment.subspan<1, kLongestCode>();
    std::size_t codes = 0;
    for (const std::uint8_t count : counts) codes += count;
    if (segment.size() < 1 + kLongestCode + codes) return false;
    auto table = HuffmanTable::FromCounts(counts, segment.subspan(1 + kLongestCode, codes));
    if (!table) return false;
    header.tables[segment[0]] = std::move(table);
    segment = segment.subspan(1 + kLongestCode + codes);
  }
  return true;
}

// All components at once, in the frame's order, predicted by the left neighbour, no bits cut off.
bool ReadScan(Bytes segment, Header& header) {
  const auto count = static_cast<std::size_t>(header.shape.components);
  if (count == 0 || segment.size() < 4 + 2 * count || segment[0] != count) return false;
  for (std::size_t c = 0; c < count; ++c) {
    const Component& component = header.components[c];
    const std::size_t table = segment[2 + 2 * c] >> 4U;
    if (segment[1 + 2 * c] != component.name || component.scale != 0x11 || table >= kMostTables ||
        !header.tables[table])
      return false;
    header.table_of[c] = table;
  }
  return segment[1 + 2 * count] == kLeftNeighbour && (segment[3 + 2 * count] & 15U) == 0;
}

}  // namespace

std::optional<LosslessJpeg> LosslessJpeg::Open(Bytes data) {
  if (data.size() < 2 || data[0] != 0xFF || data[1] != kStart) return std::nullopt;
  Header header;
  std::size_t at = 2;
  while (at + 4 <= data.size() && data[at] == 0xFF) {
    const std::uint8_t marker = data[at + 1];
    const auto length = static_cast<std::size_t>(TwoBytes(data, at + 2));  // its own two bytes counted in
    if (length < 2 || at + 2 + length > data.size()) return std::nullopt;
    const Bytes segment = data.subspan(at + 4, length - 2);
    at += 2 + length;
    const bool good = marker == kLosslessHuffman   ? ReadFrame(segment, header)
                      : marker == kTables          ? ReadTables(segment, header)
                      : marker == kScan            ? ReadScan(segment, header)
                      : marker == kRestartInterval ? segment.size() == 2 && TwoBytes(segment, 0) == 0
                                                   : marker >= 0xE0;  // makers' own, and comments
    if (!good) return std::nullopt;
    if (marker != kScan) continue;
    LosslessJpeg jpeg(header.shape, data.subspan(at));
    for (std::size_t c = 0; c < static_cast<std::size_t>(header.shape.components); ++c)
      jpeg.tables_[c] = *header.tables[header.table_of[c]];
    jpeg.line_above_.fill(static_cast<std::uint16_t>(1U << (header.shape.bits - 1)));
    return jpeg;
  }
  return std::nullopt;
}

// Returns all bits that occur in any value.
template <int kComponents>
unsigned LosslessJpeg::Decode(std::span<std::uint16_t> values) {
  // Four differences from the quick table fit into the window.
  static_assert(4 * HuffmanTable::kQuickBits <= JpegBits::kFilled);
  std::array<std::uint16_t, kComponents> left{};
  for (std::size_t c = 0; c < kComponents; ++c) left[c] = line_above_[c];
  JpegBits bits = bits_;  // in registers while it lasts
  unsigned seen = 0;
  const std::size_t whole = values.size() & ~std::size_t{3};
  const auto next = [&](std::size_t i, std::size_t c) {
    left[c] = static_cast<std::uint16_t>(left[c] + tables_[c].Difference(bits));
    values[i] = left[c];
    seen |= left[c];
  };
  for (std::size_t i = 0; i < whole; i += 4) {
    bits.Fill();
    for (std::size_t k = 0; k < 4; ++k) next(i + k, k % kComponents);
  }
  bits.Fill();
  for (std::size_t i = whole; i < values.size(); ++i) next(i, i % kComponents);
  for (std::size_t c = 0; c < kComponents; ++c) line_above_[c] = values[c];
  bits_ = bits;
  return seen;
}

bool LosslessJpeg::NextLine(std::span<std::uint16_t> values) {
  assert(values.size() == static_cast<std::size_t>(values_per_line()));
  const unsigned seen = shape_.components == 1   ? Decode<1>(values)
                        : shape_.components == 2 ? Decode<2>(values)
                                                 : Decode<4>(values);
  return !bits_.Broken() && seen >> shape_.bits == 0;
}

}  // namespace dermap
