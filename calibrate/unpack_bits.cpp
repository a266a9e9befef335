// SPDX-License-Identifier: Apache-2.0
// Three bytes at a time.
#include "calibrate/unpack_bits.h"

#include "common/core/kernel.h"

namespace dermap {
namespace {

// Two values of 12 bits in three bytes.
DERMAP_KERNEL void UnpackPairs(const std::uint8_t* bytes, std::size_t pairs, std::uint16_t* values) {
  for (std::size_t i = 0; i < pairs; ++i) {
    const unsigned a = bytes[3 * i], b = bytes[3 * i + 1], c = bytes[3 * i + 2];
    values[2 * i] = static_cast<std::uint16_t>(a << 4U | b >> 4U);
    values[2 * i + 1] = static_cast<std::uint16_t>((b & 15U) << 8U | c);
  }
}

}  // namespace

void UnpackBits(std::span<const std::uint8_t> bytes, int bits, std::span<std::uint16_t> values) {
  const std::size_t pairs = bits == 12 ? values.size() / 2 : 0;
  UnpackPairs(bytes.data(), pairs, values.data());
  const unsigned mask = (1U << bits) - 1U;
  std::size_t bit = 2 * pairs * static_cast<std::size_t>(bits);
  for (std::uint16_t& value : values.subspan(2 * pairs)) {
    // Three bytes hold any value: 7 bits before it and 15 of its own.
    const std::uint8_t* b = bytes.data() + (bit >> 3U);
    const unsigned window = static_cast<unsigned>(b[0]) << 16U | static_cast<unsigned>(b[1]) << 8U | b[2];
    value = static_cast<std::uint16_t>(window >> (24U - static_cast<unsigned>(bits) - (bit & 7U)) & mask);
    bit += static_cast<std::size_t>(bits);
  }
}

}  // namespace dermap
