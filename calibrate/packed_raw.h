// SPDX-License-Identifier: Apache-2.0
// LibRaw with a quick way through DNG files whose values are packed without compression (12 bits, mostly):
// LibRaw's own asks its stream for one byte after another, which takes 25 times as long.
#pragma once

#include <libraw/libraw.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace dermap {

// Values of `bits` (9 to 15) each, the first one's highest bit first, from bytes that go on for at least
// three more than the values fill.
void UnpackBits(std::span<const std::uint8_t> bytes, int bits, std::span<std::uint16_t> values);

class PackedRaw : public LibRaw {
 public:
  // Between open_*() and unpack(): puts the quick decoder in the place of LibRaw's where it reads the file
  // alike.
  void DecodeQuickly();

 private:
  void LoadPacked();

  void (LibRaw::*slow_)() = nullptr;
};

}  // namespace dermap
