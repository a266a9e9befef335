// SPDX-License-Identifier: Apache-2.0
// Nikon's and Sony's files: one directory, its EXIF, one strip; and DNG, in a strip or in tiles.
#include "tests/calibrate/camera_files.h"

#include <algorithm>

#include "tests/calibrate/jpeg_writer.h"
#include "tests/calibrate/tiff_parts.h"

namespace dermap {
namespace {

// Where the photosites' data lie: one strip, or tiles in a row.
struct DataPlace {
  std::vector<std::uint32_t> sizes;
  std::uint32_t first_at = 0;
  int tile_width = 0;  // 0: a strip
  std::vector<std::uint32_t> Offsets() const {
    std::vector<std::uint32_t> offsets{first_at};
    for (std::size_t i = 0; i + 1 < sizes.size(); ++i) offsets.push_back(offsets.back() + sizes[i]);
    return offsets;
  }
};

Directory MainDirectory(const Numbers& numbers, const Plane<std::uint16_t>& photosites,
                        const CameraFile& file, const DataPlace& place, std::uint32_t exif_at) {
  const auto width = static_cast<std::uint32_t>(photosites.width());
  const auto height = static_cast<std::uint32_t>(photosites.height());
  Directory ifd(numbers);
  ifd.Longs(254, {0});  // the image itself
  ifd.Longs(256, {width});
  ifd.Longs(257, {height});
  ifd.Shorts(258, {static_cast<std::uint32_t>(file.bits)});
  ifd.Shorts(259, {file.compression});
  ifd.Shorts(262, {32803});  // colour filter array
  ifd.Text(271, file.make);
  ifd.Text(272, file.model);
  const bool strip = place.tile_width == 0;
  if (strip) ifd.Longs(273, place.Offsets());
  ifd.Shorts(274, {static_cast<std::uint32_t>(file.orientation)});
  ifd.Shorts(277, {1});
  if (strip) {
    ifd.Longs(278, {height});
    ifd.Longs(279, place.sizes);
  } else {
    ifd.Longs(322, {static_cast<std::uint32_t>(place.tile_width)});
    ifd.Longs(323, {height});
    ifd.Longs(324, place.Offsets());
    ifd.Longs(325, place.sizes);
  }
  if (file.make == "SONY") {
    std::vector<std::uint32_t> black(file.black.begin(), file.black.end());
    ifd.Shorts(29456, black);
  }
  ifd.Shorts(33421, {2, 2});
  Bytes cell;
  for (const std::uint8_t f : file.filters) cell.push_back(std::byte{f});
  ifd.Raw(33422, 1, cell);
  ifd.Longs(34665, {exif_at});
  if (file.dng) {
    ifd.Raw(50706, 1, {std::byte{1}, std::byte{4}, std::byte{0}, std::byte{0}});  // DNGVersion
    ifd.Text(50708, file.model);
    if (!file.curve.empty()) ifd.Shorts(50712, file.curve);  // LinearizationTable
    ifd.Shorts(50714, {static_cast<std::uint32_t>(file.black[0])});
    ifd.Longs(50717, {file.curve.empty() ? (1U << file.bits) - 1U : file.curve.back()});
  }
  return ifd;
}

Bytes FileOf(bool big_endian, const Plane<std::uint16_t>& photosites, const CameraFile& file,
             const std::vector<Bytes>& data, const Bytes& maker_note, int tile_width = 0) {
  const Numbers numbers(big_endian);
  constexpr std::uint32_t kFirst = 8;
  DataPlace place;
  place.tile_width = tile_width;
  for (const Bytes& part : data) place.sizes.push_back(static_cast<std::uint32_t>(part.size()));
  const Directory exif = Exif(numbers, maker_note);
  const std::uint32_t exif_at = kFirst + MainDirectory(numbers, photosites, file, place, 0).Size();
  place.first_at = exif_at + exif.Size();
  Bytes out = numbers.Header();
  Append(out, numbers.Of(kFirst, 4));
  Append(out, MainDirectory(numbers, photosites, file, place, exif_at).At(kFirst));
  Append(out, exif.At(exif_at));
  for (const Bytes& part : data) Append(out, part);
  return out;
}

Bytes SixteenBits(const Numbers& numbers, const Plane<std::uint16_t>& photosites) {
  Bytes out;
  for (const std::uint16_t v : photosites.values()) Append(out, numbers.Of(v, 2));
  return out;
}

// `coding`: what tells the decoder its table; empty where the photosites are not compressed.
Bytes NikonNote(const std::array<int, 4>& black, const Bytes& coding = {}) {
  const Numbers numbers(true);
  Bytes note;
  for (const char c : std::string_view("Nikon\0\2\x10\0\0", 10)) note.push_back(static_cast<std::byte>(c));
  Append(note, numbers.Header());
  Append(note, numbers.Of(8, 4));
  Directory ifd(numbers);
  ifd.Shorts(0x3D, {black.begin(), black.end()});
  if (!coding.empty()) ifd.Raw(0x96, 7, coding);
  Append(note, ifd.At(8));
  return note;
}

}  // namespace

std::vector<std::byte> EncodeNef(const Plane<std::uint16_t>& photosites, const CameraFile& file) {
  Bytes strip;
  if (file.bits == 12) {
    BitWriter writer(false);
    for (const std::uint16_t v : photosites.values()) writer.Put(v, 12);
    strip = writer.Finish();
  } else {
    strip = SixteenBits(Numbers(true), photosites);
  }
  return FileOf(true, photosites, file, {strip}, NikonNote(file.black));
}

std::vector<std::byte> EncodeCameraDng(const Plane<std::uint16_t>& photosites, CameraFile file) {
  file.dng = true;
  Bytes strip;
  for (int y = 0; y < photosites.height(); ++y) {
    BitWriter writer(false);
    for (int x = 0; x < photosites.width(); ++x) writer.Put(photosites(x, y), file.bits);
    Append(strip, writer.Finish());
  }
  return FileOf(true, photosites, file, {strip}, {});
}

std::vector<std::byte> EncodeArw(const Plane<std::uint16_t>& photosites, const CameraFile& file) {
  return FileOf(false, photosites, file, {SixteenBits(Numbers(false), photosites)}, {});
}

std::vector<std::byte> EncodeLosslessDng(const Plane<std::uint16_t>& photosites, CameraFile file,
                                         int tile_width) {
  file.dng = true;
  file.compression = 7;
  std::vector<Bytes> tiles;
  for (int x = 0; x < photosites.width(); x += tile_width) {
    std::vector<std::uint16_t> values;  // beyond the frame's border the last one goes on
    for (int y = 0; y < photosites.height(); ++y) {
      for (int i = 0; i < tile_width; ++i)
        values.push_back(photosites(std::min(x + i, photosites.width() - 1), y));
    }
    const JpegLayout layout{photosites.height(), tile_width / 2, 2, file.bits};
    tiles.push_back(EncodeLosslessJpeg(values, layout, {ShortestCode(values, layout)}));
  }
  return FileOf(true, photosites, file, tiles, {}, tile_width);
}

std::vector<std::byte> EncodeLosslessNef(const Plane<std::uint16_t>& photosites, CameraFile file) {
  // Nikon's own codes of lossless differences, the same in every file; other tools know them as well.
  JpegCode code;
  if (file.bits == 12) {
    code = {{0, 1, 4, 2, 3, 1, 2}, {5, 4, 6, 3, 7, 2, 8, 1, 9, 0, 10, 11, 12}};
  } else {
    code = {{0, 1, 4, 2, 2, 3, 1, 2}, {7, 6, 8, 5, 9, 4, 10, 3, 11, 12, 2, 0, 1, 13, 14}};
  }
  const HuffmanCodes codes = CodesOf(code);
  const Numbers numbers(true);
  const int middle = 1 << (file.bits - 1);
  Bytes coding{std::byte{0x46}, std::byte{0x30}};  // lossless
  for (int i = 0; i < 4; ++i) Append(coding, numbers.Of(static_cast<std::uint32_t>(middle), 2));
  Append(coding, numbers.Of(0, 2));  // no curve
  BitWriter writer(false);
  std::array<std::array<int, 2>, 2> above{{{middle, middle}, {middle, middle}}};  // of even and odd rows
  for (int y = 0; y < photosites.height(); ++y) {
    for (int x = 0; x < photosites.width(); ++x) {
      int& first = above[static_cast<std::size_t>(y % 2)][static_cast<std::size_t>(x % 2)];
      const int before = x < 2 ? first : photosites(x - 2, y);
      if (x < 2) first = photosites(x, y);
      PutDifference(codes, photosites(x, y) - before, writer);
    }
  }
  file.compression = 34713;
  return FileOf(true, photosites, file, {writer.Finish()}, NikonNote(file.black, coding));
}

std::vector<std::byte> EncodeCompressedArw(const Plane<std::uint16_t>& photosites, CameraFile file) {
  constexpr int kTogether = 16;
  Bytes strip;
  for (int y = 0; y < photosites.height(); ++y) {
    for (int group = 0; group < photosites.width() / kTogether; ++group) {
      std::array<int, kTogether> steps{};  // of 2; even columns first, then the odd ones among them
      for (int i = 0; i < kTogether; ++i)
        steps[static_cast<std::size_t>(i)] = photosites(group / 2 * 2 * kTogether + 2 * i + group % 2, y) / 2;
      const auto largest = std::max_element(steps.begin(), steps.end());
      const auto smallest = std::find_if(steps.begin(), steps.end(), [&](const int& v) {
        return &v != &*largest && v == *std::min_element(steps.begin(), steps.end());
      });
      std::array<int, 128> bits{};  // lowest first
      int at = 0;
      const auto put = [&](int value, int count) {
        for (int i = 0; i < count; ++i) bits[static_cast<std::size_t>(at++)] = value >> i & 1;
      };
      put(*largest, 11), put(*smallest, 11);
      put(static_cast<int>(largest - steps.begin()), 4), put(static_cast<int>(smallest - steps.begin()), 4);
      for (auto step = steps.begin(); step != steps.end(); ++step) {
        if (step != largest && step != smallest) put(*step - *smallest, 7);
      }
      for (std::size_t i = 0; i < bits.size(); i += 8) {
        int byte = 0;
        for (std::size_t k = 0; k < 8; ++k) byte |= bits[i + k] << k;
        strip.push_back(static_cast<std::byte>(byte));
      }
    }
  }
  file.compression = 32767;
  return FileOf(false, photosites, file, {strip}, {});
}

}  // namespace dermap
