// SPDX-License-Identifier: Apache-2.0
// Nikon's and Sony's uncompressed files: one directory, its EXIF, one strip.
#include "tests/calibrate/camera_files.h"

#include "tests/calibrate/tiff_parts.h"

namespace dermap {
namespace {

Directory Uncompressed(const Numbers& numbers, const Plane<std::uint16_t>& photosites, const CameraFile& file,
                       std::size_t strip_size, std::uint32_t strip_at, std::uint32_t exif_at) {
  const auto width = static_cast<std::uint32_t>(photosites.width());
  const auto height = static_cast<std::uint32_t>(photosites.height());
  Directory ifd(numbers);
  ifd.Longs(254, {0});  // the image itself
  ifd.Longs(256, {width});
  ifd.Longs(257, {height});
  ifd.Shorts(258, {static_cast<std::uint32_t>(file.bits)});
  ifd.Shorts(259, {1});      // not compressed
  ifd.Shorts(262, {32803});  // colour filter array
  ifd.Text(271, file.make);
  ifd.Text(272, file.model);
  ifd.Longs(273, {strip_at});
  ifd.Shorts(274, {static_cast<std::uint32_t>(file.orientation)});
  ifd.Shorts(277, {1});
  ifd.Longs(278, {height});
  ifd.Longs(279, {static_cast<std::uint32_t>(strip_size)});
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

Bytes UncompressedFile(bool big_endian, const Plane<std::uint16_t>& photosites, const CameraFile& file,
                       const Bytes& strip, const Bytes& maker_note) {
  const Numbers numbers(big_endian);
  constexpr std::uint32_t kFirst = 8;
  const auto directory = [&](std::uint32_t strip_at, std::uint32_t exif_at) {
    return Uncompressed(numbers, photosites, file, strip.size(), strip_at, exif_at);
  };
  const Directory exif = Exif(numbers, maker_note);
  const std::uint32_t exif_at = kFirst + directory(0, 0).Size();
  const std::uint32_t strip_at = exif_at + exif.Size();
  Bytes out = numbers.Header();
  Append(out, numbers.Of(kFirst, 4));
  Append(out, directory(strip_at, exif_at).At(kFirst));
  Append(out, exif.At(exif_at));
  Append(out, strip);
  return out;
}

Bytes SixteenBits(const Numbers& numbers, const Plane<std::uint16_t>& photosites) {
  Bytes out;
  for (const std::uint16_t v : photosites.values()) Append(out, numbers.Of(v, 2));
  return out;
}

Bytes NikonNote(const std::array<int, 4>& black) {
  const Numbers numbers(true);
  Bytes note;
  for (const char c : std::string_view("Nikon\0\2\x10\0\0", 10)) note.push_back(static_cast<std::byte>(c));
  Append(note, numbers.Header());
  Append(note, numbers.Of(8, 4));
  Directory ifd(numbers);
  ifd.Shorts(0x3D, {black.begin(), black.end()});
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
  return UncompressedFile(true, photosites, file, strip, NikonNote(file.black));
}

std::vector<std::byte> EncodeCameraDng(const Plane<std::uint16_t>& photosites, CameraFile file) {
  file.dng = true;
  Bytes strip;
  for (int y = 0; y < photosites.height(); ++y) {
    BitWriter writer(false);
    for (int x = 0; x < photosites.width(); ++x) writer.Put(photosites(x, y), file.bits);
    Append(strip, writer.Finish());
  }
  return UncompressedFile(true, photosites, file, strip, {});
}

std::vector<std::byte> EncodeArw(const Plane<std::uint16_t>& photosites, const CameraFile& file) {
  return UncompressedFile(false, photosites, file, SixteenBits(Numbers(false), photosites), {});
}

}  // namespace dermap
