// SPDX-License-Identifier: Apache-2.0
// Lossless JPEG (ITU-T T.81, process 14) as cameras write it: each value predicted by the one to its left.
// Written for tests alone, straight from the standard, bit by bit.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tests/calibrate/tiff_parts.h"

namespace dermap {

// Codes of a table: how many there are of 1 to 16 bits, and the categories that they mean, shortest first.
struct JpegCode {
  std::array<int, 16> counts{};
  std::vector<int> categories;
};

// Categories 0 to 16, five bits each.
JpegCode CodeOfFiveBits();
// Categories 0 to 14, of 2 to 16 bits: longer than any reader's table of beginnings.
JpegCode CodeOfGrowingLength();

struct JpegLayout {
  int lines = 0, columns = 0, components = 1;
  int bits = 12;
};

struct HuffmanCodes {  // by category
  std::array<std::uint32_t, 17> code{};
  std::array<int, 17> length{};
};
// Consecutive numbers for each length [T.81 annex C].
HuffmanCodes CodesOf(const JpegCode& table);
// A difference in its category's code and as many bits as the category says.
void PutDifference(const HuffmanCodes& codes, int difference, BitWriter& writer);

// The shortest code for these values in the mean (Huffman 1952), as cameras have it.
JpegCode ShortestCode(const std::vector<std::uint16_t>& values, const JpegLayout& layout);

// `values`: line after line, components interleaved. `codes`: one for all components, or one for each.
Bytes EncodeLosslessJpeg(const std::vector<std::uint16_t>& values, const JpegLayout& layout,
                         const std::vector<JpegCode>& codes);

}  // namespace dermap
