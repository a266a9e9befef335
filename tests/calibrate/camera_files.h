// SPDX-License-Identifier: Apache-2.0
// Raw files as makers' cameras write them, as far as their formats are published: TIFF 6.0 with the makers'
// tags, and lossless JPEG (ITU-T T.81, annex H). Written for tests alone, so that readers are held to known
// photosites.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/core/image.h"

namespace dermap {

// What a file tells beside its photosites.
struct CameraFile {
  std::string make, model;
  int bits = 14;
  std::array<std::uint8_t, 4> filters{0, 1, 1, 2};  // 0 red, 1 green, 2 blue: a cell, row by row
  std::array<int, 4> black{};  // of red, green, green, blue; where the format has a place
  int orientation = 1;
  bool dng = false;
  std::uint32_t compression = 1;       // TIFF's number; 1 is none
  std::vector<std::uint32_t> curve{};  // of a DNG: what each stored number means; empty: itself
};

// A DNG of this height and width in tiles, each a lossless JPEG of two components, as Adobe's converter has
// it.
std::vector<std::byte> EncodeLosslessDng(const Plane<std::uint16_t>& photosites, CameraFile file,
                                         int tile_width);
// Nikon's lossless compression of 12 or 14 bits: differences to the photosite of the same colour on the left,
// in a code of Nikon's own that no file states.
std::vector<std::byte> EncodeLosslessNef(const Plane<std::uint16_t>& photosites, CameraFile file);
// Sony's compression: 16 photosites of a colour in 16 bytes, the largest and the smallest of them with 11
// bits, the others as their distance from the smallest with 7. Lossless where they lie less than 128 steps of
// 2 apart.
std::vector<std::byte> EncodeCompressedArw(const Plane<std::uint16_t>& photosites, CameraFile file);
// Nikon: big-endian, uncompressed; 12 bits packed, or 14 bits in 16. The black level is in the maker note.
std::vector<std::byte> EncodeNef(const Plane<std::uint16_t>& photosites, const CameraFile& file);
// Sony: little-endian, uncompressed, 14 bits in 16.
std::vector<std::byte> EncodeArw(const Plane<std::uint16_t>& photosites, const CameraFile& file);
// DNG as cameras write it without compression: big-endian, `bits` packed, every row from a byte of its own.
std::vector<std::byte> EncodeCameraDng(const Plane<std::uint16_t>& photosites, CameraFile file);
// Canon: lossless JPEG of two components, in strips side by side of `strip_width` photosites (0: one).
std::vector<std::byte> EncodeCr2(const Plane<std::uint16_t>& photosites, const CameraFile& file,
                                 int strip_width = 0);

}  // namespace dermap
