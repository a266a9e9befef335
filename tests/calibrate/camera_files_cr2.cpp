// SPDX-License-Identifier: Apache-2.0
// Canon's CR2: a directory for the picture, one for the photosites, a lossless JPEG coder with one fixed
// table.
#include <algorithm>
#include <bit>
#include <cstdlib>

#include "tests/calibrate/camera_files.h"
#include "tests/calibrate/tiff_parts.h"

namespace dermap {
namespace {

// Marker, length, content.
Bytes Segment(int marker, const std::vector<int>& content) {
  const Numbers numbers(true);
  Bytes out = numbers.Of(0xFF00U + static_cast<std::uint32_t>(marker), 2);
  Append(out, numbers.Of(static_cast<std::uint32_t>(content.size()) + 2, 2));
  for (const int c : content) out.push_back(static_cast<std::byte>(c));
  return out;
}

// Two components side by side, each predicted by the one before it of its kind; 15 categories, 5 bits each.
Bytes LosslessJpeg(const std::vector<std::uint16_t>& values, int width, int height, int bits) {
  Bytes out{std::byte{0xFF}, std::byte{0xD8}};
  std::vector<int> table{0, 0, 0, 0, 0, 15, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  for (int category = 0; category < 15; ++category) table.push_back(category);
  Append(out, Segment(0xC4, table));
  const int columns = width / 2;
  Append(out, Segment(0xC3, {bits, height >> 8, height & 0xFF, columns >> 8, columns & 0xFF, 2, 1, 0x11, 0, 2,
                             0x11, 0}));
  Append(out, Segment(0xDA, {2, 1, 0, 2, 0, 1, 0, 0}));
  BitWriter writer(true);
  std::array<int, 2> above{1 << (bits - 1), 1 << (bits - 1)};
  for (int y = 0; y < height; ++y) {
    std::array<int, 2> left = above;
    for (int x = 0; x < width; ++x) {
      const int value = values[static_cast<std::size_t>(y) * width + x];
      if (x < 2) above[x] = value;
      const int difference = value - left[x % 2];
      left[x % 2] = value;
      const int category = std::bit_width(static_cast<unsigned>(std::abs(difference)));
      writer.Put(static_cast<std::uint32_t>(category), 5);
      const int coded = difference > 0 ? difference : difference + (1 << category) - 1;
      writer.Put(static_cast<std::uint32_t>(coded), category);
    }
  }
  Append(out, writer.Finish());
  out.push_back(std::byte{0xFF});
  out.push_back(std::byte{0xD9});
  return out;
}

}  // namespace

std::vector<std::byte> EncodeCr2(const Plane<std::uint16_t>& photosites, const CameraFile& file,
                                 int strip_width) {
  const Numbers numbers(false);
  const int width = photosites.width(), height = photosites.height();
  const int strip = strip_width > 0 ? strip_width : width;
  std::vector<std::uint16_t> values;  // strip after strip
  for (int first = 0; first < width; first += strip) {
    for (int y = 0; y < height; ++y)
      values.insert(values.end(), photosites.Row(y) + first,
                    photosites.Row(y) + std::min(width, first + strip));
  }
  const Bytes jpeg = LosslessJpeg(values, width, height, file.bits);
  const auto preview = [&](std::uint32_t exif_at) {
    Directory ifd(numbers);
    ifd.Longs(256, {static_cast<std::uint32_t>(width)});
    ifd.Longs(257, {static_cast<std::uint32_t>(height)});
    ifd.Shorts(258, {8, 8, 8});  // a picture in colours, which nobody takes for the photosites
    ifd.Shorts(259, {6});
    ifd.Text(271, file.make);
    ifd.Text(272, file.model);
    ifd.Shorts(274, {static_cast<std::uint32_t>(file.orientation)});
    ifd.Longs(34665, {exif_at});
    return ifd;
  };
  const auto raw = [&](std::uint32_t strip_at) {
    Directory ifd(numbers);
    ifd.Shorts(259, {6});
    ifd.Longs(273, {strip_at});
    ifd.Longs(279, {static_cast<std::uint32_t>(jpeg.size())});
    const int before = (width - 1) / strip;  // strips but the last
    ifd.Shorts(50752, {static_cast<std::uint32_t>(before), static_cast<std::uint32_t>(strip),
                       static_cast<std::uint32_t>(width - before * strip)});
    return ifd;
  };
  const Directory exif = Exif(numbers, {});
  constexpr std::uint32_t kFirst = 16;
  const std::uint32_t raw_at = kFirst + preview(0).Size();
  const std::uint32_t exif_at = raw_at + raw(0).Size();
  const std::uint32_t strip_at = exif_at + exif.Size();
  Bytes out = numbers.Header();
  Append(out, numbers.Of(kFirst, 4));
  for (const int c : {int('C'), int('R'), 2, 0}) out.push_back(static_cast<std::byte>(c));
  Append(out, numbers.Of(raw_at, 4));
  Append(out, preview(exif_at).At(kFirst, raw_at));
  Append(out, raw(strip_at).At(raw_at));
  Append(out, exif.At(exif_at));
  Append(out, jpeg);
  return out;
}

}  // namespace dermap
