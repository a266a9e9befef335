// SPDX-License-Identifier: Apache-2.0
// Values of any number of bits, packed without gaps: what cameras' files hold that are not compressed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace dermap {

inline constexpr int kFewestPackedBits = 9, kMostPackedBits = 15;  // 8 and 16 need no unpacking
inline constexpr std::size_t kBytesBeyondPacked = 2;               // read after the last value's own

// Values of `bits` each, the first one's highest bit first, from bytes that go on for kBytesBeyondPacked.
void UnpackBits(std::span<const std::uint8_t> bytes, int bits, std::span<std::uint16_t> values);

}  // namespace dermap
