// SPDX-License-Identifier: Apache-2.0
// Differences [T.81 H.1.2], their codes [annex C], segments [B.2].
#include "tests/calibrate/jpeg_writer.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <numeric>

namespace dermap {
namespace {

constexpr int kCategories = 17;

// Marker, length, content.
Bytes Segment(int marker, const std::vector<int>& content) {
  const Numbers numbers(true);
  Bytes out = numbers.Of(0xFF00U + static_cast<std::uint32_t>(marker), 2);
  Append(out, numbers.Of(static_cast<std::uint32_t>(content.size()) + 2, 2));
  for (const int c : content) out.push_back(static_cast<std::byte>(c));
  return out;
}

// Modulo 2^16, from -32767 to 32768.
std::vector<int> DifferencesOf(const std::vector<std::uint16_t>& values, const JpegLayout& layout) {
  std::vector<int> differences;
  const int width = layout.columns * layout.components;
  for (int i = 0; i < static_cast<int>(values.size()); ++i) {
    const bool first = i % width < layout.components;
    const int before = !first      ? values[static_cast<std::size_t>(i - layout.components)]
                       : i < width ? 1 << (layout.bits - 1)
                                   : values[static_cast<std::size_t>(i - width)];
    const int difference = static_cast<std::int16_t>(values[static_cast<std::size_t>(i)] - before);
    differences.push_back(difference == -32768 ? 32768 : difference);
  }
  return differences;
}

int CategoryOf(int difference) {
  return std::bit_width(static_cast<unsigned>(std::abs(difference)));
}

}  // namespace

HuffmanCodes CodesOf(const JpegCode& table) {
  HuffmanCodes codes;
  std::uint32_t code = 0;
  std::size_t k = 0;
  for (int length = 1; length <= 16; ++length, code <<= 1) {
    for (int i = 0; i < table.counts[static_cast<std::size_t>(length - 1)]; ++i, ++code, ++k) {
      const auto category = static_cast<std::size_t>(table.categories[k]);
      codes.code[category] = code;
      codes.length[category] = length;
    }
  }
  return codes;
}

void PutDifference(const HuffmanCodes& codes, int difference, BitWriter& writer) {
  const int category = CategoryOf(difference);
  const auto c = static_cast<std::size_t>(category);
  writer.Put(codes.code[c], codes.length[c]);
  const int coded = difference > 0 ? difference : difference + (1 << category) - 1;
  writer.Put(static_cast<std::uint32_t>(coded), category == 16 ? 0 : category);
}

JpegCode CodeOfFiveBits() {
  JpegCode code;
  code.counts[4] = kCategories;
  code.categories.resize(kCategories);
  std::iota(code.categories.begin(), code.categories.end(), 0);
  return code;
}

JpegCode CodeOfGrowingLength() {
  JpegCode code;
  for (int category = 0; category < 15; ++category) {
    code.counts[static_cast<std::size_t>(category + 1)] = 1;
    code.categories.push_back(category);
  }
  return code;
}

JpegCode ShortestCode(const std::vector<std::uint16_t>& values, const JpegLayout& layout) {
  struct Node {
    double weight;
    std::vector<int> categories;
  };
  std::array<double, kCategories> weights{};
  for (const int difference : DifferencesOf(values, layout))
    weights[static_cast<std::size_t>(CategoryOf(difference))] += 1.0;
  // One that never comes up gets the code of ones alone, which the standard keeps free.
  constexpr int kNone = kCategories;
  std::vector<Node> nodes{{0.0, {kNone}}};
  for (int c = 0; c < kCategories; ++c) {
    if (weights[static_cast<std::size_t>(c)] > 0.0)
      nodes.push_back({weights[static_cast<std::size_t>(c)], {c}});
  }
  std::array<int, kCategories + 1> length{};
  while (nodes.size() > 1) {
    std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.weight > b.weight; });
    const Node least = nodes.back();
    nodes.pop_back();
    nodes.back().weight += least.weight;
    auto& joined = nodes.back().categories;
    joined.insert(joined.end(), least.categories.begin(), least.categories.end());
    for (const int c : joined) ++length[static_cast<std::size_t>(c)];
  }
  if (*std::max_element(length.begin(), length.end() - 1) > 16) return CodeOfFiveBits();
  JpegCode code;
  for (int l = 1; l <= 16; ++l) {
    for (int c = 0; c < kCategories; ++c) {
      if (length[static_cast<std::size_t>(c)] != l) continue;
      ++code.counts[static_cast<std::size_t>(l - 1)];
      code.categories.push_back(c);
    }
  }
  return code;
}

Bytes EncodeLosslessJpeg(const std::vector<std::uint16_t>& values, const JpegLayout& layout,
                         const std::vector<JpegCode>& codes) {
  Bytes out{std::byte{0xFF}, std::byte{0xD8}};
  std::vector<HuffmanCodes> tables;
  for (const JpegCode& code : codes) {
    std::vector<int> content{static_cast<int>(tables.size())};
    content.insert(content.end(), code.counts.begin(), code.counts.end());
    content.insert(content.end(), code.categories.begin(), code.categories.end());
    Append(out, Segment(0xC4, content));
    tables.push_back(CodesOf(code));
  }
  std::vector<int> frame{layout.bits,         layout.lines >> 8,     layout.lines & 0xFF,
                         layout.columns >> 8, layout.columns & 0xFF, layout.components};
  std::vector<int> scan{layout.components};
  const auto table_of = [&](int component) { return codes.size() > 1 ? component : 0; };
  for (int c = 0; c < layout.components; ++c) {
    frame.insert(frame.end(), {c + 1, 0x11, 0});
    scan.insert(scan.end(), {c + 1, table_of(c) << 4});
  }
  scan.insert(scan.end(), {1, 0, 0});  // predicted by the left neighbour
  Append(out, Segment(0xC3, frame));
  Append(out, Segment(0xDA, scan));
  BitWriter writer(true);
  const std::vector<int> differences = DifferencesOf(values, layout);
  for (std::size_t i = 0; i < differences.size(); ++i) {
    const int component = static_cast<int>(i) % layout.components;
    PutDifference(tables[static_cast<std::size_t>(table_of(component))], differences[i], writer);
  }
  Append(out, writer.Finish());
  Append(out, {std::byte{0xFF}, std::byte{0xD9}});
  return out;
}

}  // namespace dermap
