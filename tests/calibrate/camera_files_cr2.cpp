// SPDX-License-Identifier: Apache-2.0
// Canon's CR2: a directory for the picture, one for the photosites, which are a lossless JPEG.
#include <algorithm>

#include "tests/calibrate/camera_files.h"
#include "tests/calibrate/jpeg_writer.h"
#include "tests/calibrate/tiff_parts.h"

namespace dermap {

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
  const JpegLayout layout{height, width / 2, 2, file.bits};
  const Bytes jpeg = EncodeLosslessJpeg(values, layout, {ShortestCode(values, layout)});
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
