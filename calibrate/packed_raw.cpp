// SPDX-License-Identifier: Apache-2.0
// What LibRaw calls packed_dng_load_raw, row by row instead of bit by bit. All else (levels, covered margins,
// sizes) stays LibRaw's.
#include "calibrate/packed_raw.h"

#include <climits>
#include <string_view>
#include <vector>

#include "common/core/kernel.h"

namespace dermap {
namespace {

constexpr int kFewestBits = 9, kMostBits = 15;  // 8 and 16 need no unpacking
constexpr std::size_t kSpareBytes = 4;          // read beyond the last value

// Two values of 12 bits in three bytes.
DERMAP_KERNEL void UnpackPairs(const std::uint8_t* bytes, std::size_t pairs, std::uint16_t* values) {
  for (std::size_t i = 0; i < pairs; ++i) {
    const unsigned a = bytes[3 * i], b = bytes[3 * i + 1], c = bytes[3 * i + 2];
    values[2 * i] = static_cast<std::uint16_t>(a << 4U | b >> 4U);
    values[2 * i + 1] = static_cast<std::uint16_t>((b & 15U) << 8U | c);
  }
}

bool IsIdentity(const std::uint16_t* curve, int bits) {
  for (int v = 0; v < 1 << bits; ++v) {
    if (curve[v] != v) return false;
  }
  return true;
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

void PackedRaw::DecodeQuickly() {
  const auto& data = libraw_internal_data.unpacker_data;
  libraw_decoder_info_t decoder{};
  if (get_decoder_info(&decoder) != LIBRAW_SUCCESS || decoder.decoder_name == nullptr) return;
  const bool packed = std::string_view(decoder.decoder_name) == "packed_dng_load_raw()" &&
                      data.tiff_samples == 1 && data.tile_length >= static_cast<unsigned>(INT_MAX);
  const auto bits = static_cast<int>(data.tiff_bps);
  if (!packed || bits < kFewestBits || bits > kMostBits) return;
  slow_ = load_raw;
  load_raw = static_cast<void (LibRaw::*)()>(&PackedRaw::LoadPacked);
}

// Called by unpack(), which has allocated the values and stands at their place in the file.
void PackedRaw::LoadPacked() {
  std::uint16_t* values = imgdata.rawdata.raw_image;
  if (values == nullptr) return (this->*slow_)();
  const auto& sizes = imgdata.sizes;
  const auto bits = static_cast<int>(libraw_internal_data.unpacker_data.tiff_bps);
  const std::size_t row_bytes = (std::size_t{sizes.raw_width} * static_cast<std::size_t>(bits) + 7) / 8;
  const std::size_t pitch = sizes.raw_pitch / sizeof(*values);
  const std::uint16_t* curve = imgdata.color.curve;
  const bool straight = IsIdentity(curve, bits);
  std::vector<std::uint8_t> bytes(row_bytes + kSpareBytes);
  for (int y = 0; y < sizes.raw_height; ++y) {
    if (libraw_internal_data.internal_data.input->read(bytes.data(), 1, row_bytes) !=
        static_cast<int>(row_bytes)) {
      derror();  // as LibRaw does where a file ends early
      return;
    }
    const std::span row(values + static_cast<std::size_t>(y) * pitch, sizes.raw_width);
    UnpackBits(bytes, bits, row);
    for (std::size_t x = straight ? row.size() : 0; x < row.size(); ++x) row[x] = curve[row[x]];
  }
}

}  // namespace dermap
