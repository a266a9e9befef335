// SPDX-License-Identifier: Apache-2.0
// TIFF 6.0 with the tags of the DNG 1.4 specification, little-endian, one strip.
#include "acquire/simulated/dng_writer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>

namespace dermap {
namespace {

using Bytes = std::vector<std::byte>;

void Append16(Bytes& out, std::uint32_t value) {
  out.push_back(static_cast<std::byte>(value & 0xFF));
  out.push_back(static_cast<std::byte>((value >> 8) & 0xFF));
}

void Append32(Bytes& out, std::uint32_t value) {
  Append16(out, value & 0xFFFF);
  Append16(out, value >> 16);
}

// One image file directory. Its size does not depend on its values, so offsets may be filled in afterwards.
class Directory {
 public:
  void Ascii(std::uint16_t tag, const std::string& text) {
    Bytes data;
    for (const char c : text) data.push_back(static_cast<std::byte>(c));
    data.push_back(std::byte{0});
    Add(tag, 2, static_cast<std::uint32_t>(text.size() + 1), std::move(data));
  }
  void Byte(std::uint16_t tag, const std::vector<std::uint8_t>& values) {
    Bytes data;
    for (const std::uint8_t v : values) data.push_back(static_cast<std::byte>(v));
    Add(tag, 1, static_cast<std::uint32_t>(values.size()), std::move(data));
  }
  void Undefined(std::uint16_t tag, const std::string& text) {
    Bytes data;
    for (const char c : text) data.push_back(static_cast<std::byte>(c));
    Add(tag, 7, static_cast<std::uint32_t>(text.size()), std::move(data));
  }
  void Short(std::uint16_t tag, const std::vector<std::uint32_t>& values) {
    Bytes data;
    for (const std::uint32_t v : values) Append16(data, v);
    Add(tag, 3, static_cast<std::uint32_t>(values.size()), std::move(data));
  }
  void Long(std::uint16_t tag, std::uint32_t value) {
    Bytes data;
    Append32(data, value);
    Add(tag, 4, 1, std::move(data));
  }
  void Rational(std::uint16_t tag, std::span<const double> values) { Fractions(tag, 5, values); }
  void SignedRational(std::uint16_t tag, std::span<const double> values) { Fractions(tag, 10, values); }

  std::uint32_t Size() const {
    std::uint32_t size = 2 + 12 * static_cast<std::uint32_t>(entries_.size()) + 4;
    for (const Entry& e : entries_) size += Outside(e);
    return size;
  }

  // Appends the directory and its values to `out`, whose size is the directory's offset in the file.
  void Write(Bytes& out) const {
    std::vector<Entry> sorted = entries_;
    std::sort(sorted.begin(), sorted.end(), [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
    std::uint32_t values_at =
        static_cast<std::uint32_t>(out.size()) + 2 + 12 * static_cast<std::uint32_t>(sorted.size()) + 4;
    Append16(out, static_cast<std::uint32_t>(sorted.size()));
    Bytes values;
    for (const Entry& e : sorted) {
      Append16(out, e.tag);
      Append16(out, e.type);
      Append32(out, e.count);
      if (Outside(e) == 0) {
        out.insert(out.end(), e.data.begin(), e.data.end());
        out.resize(out.size() + 4 - e.data.size());
      } else {
        Append32(out, values_at + static_cast<std::uint32_t>(values.size()));
        values.insert(values.end(), e.data.begin(), e.data.end());
        if (e.data.size() % 2 == 1) values.push_back(std::byte{0});  // values begin on word boundaries
      }
    }
    Append32(out, 0);  // no further directory
    out.insert(out.end(), values.begin(), values.end());
  }

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count;
    Bytes data;
  };
  static std::uint32_t Outside(const Entry& e) {
    const auto size = static_cast<std::uint32_t>(e.data.size());
    return size <= 4 ? 0 : size + size % 2;
  }
  void Add(std::uint16_t tag, std::uint16_t type, std::uint32_t count, Bytes data) {
    std::erase_if(entries_, [tag](const Entry& e) { return e.tag == tag; });
    entries_.push_back({tag, type, count, std::move(data)});
  }
  void Fractions(std::uint16_t tag, std::uint16_t type, std::span<const double> values) {
    constexpr double kDenominator = 1e6;
    Bytes data;
    for (const double v : values) {
      Append32(data, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(v * kDenominator))));
      Append32(data, static_cast<std::uint32_t>(kDenominator));
    }
    Add(tag, type, static_cast<std::uint32_t>(values.size()), std::move(data));
  }

  std::vector<Entry> entries_;
};

Bytes Pack12(const Plane<std::uint16_t>& bayer) {
  Bytes packed;
  packed.reserve(bayer.size() * 3 / 2);
  const auto values = bayer.values();
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
    const unsigned a = values[i], b = values[i + 1];
    assert(a <= kDngWhiteLevel && b <= kDngWhiteLevel);
    packed.push_back(static_cast<std::byte>(a >> 4));  // the most significant bit comes first
    packed.push_back(static_cast<std::byte>((a & 0xF) << 4 | b >> 8));
    packed.push_back(static_cast<std::byte>(b & 0xFF));
  }
  return packed;
}

Directory ExifDirectory(const DngMetadata& metadata) {
  Directory exif;
  const double exposure_s = metadata.exposure_ms / 1000.0;
  exif.Rational(33434, {&exposure_s, 1});  // ExposureTime
  exif.Short(34855, {static_cast<std::uint32_t>(metadata.iso)});
  exif.Undefined(36864, "0230");          // ExifVersion
  exif.Ascii(36867, metadata.date_time);  // DateTimeOriginal
  return exif;
}

void AddImageTags(Directory& ifd, const Plane<std::uint16_t>& bayer, const DngMetadata& metadata,
                  std::uint32_t strip_size) {
  ifd.Long(254, 0);  // NewSubfileType: the full-resolution image
  ifd.Long(256, static_cast<std::uint32_t>(bayer.width()));
  ifd.Long(257, static_cast<std::uint32_t>(bayer.height()));
  ifd.Short(258, {12});     // BitsPerSample
  ifd.Short(259, {1});      // not compressed
  ifd.Short(262, {32803});  // PhotometricInterpretation: colour filter array
  ifd.Ascii(270, metadata.description);
  ifd.Ascii(271, "dermap");
  ifd.Ascii(272, "dermap simulated");
  ifd.Short(274, {1});  // Orientation: as stored
  ifd.Short(277, {1});  // SamplesPerPixel
  ifd.Long(278, static_cast<std::uint32_t>(bayer.height()));
  ifd.Long(279, strip_size);
  ifd.Short(284, {1});  // PlanarConfiguration
  ifd.Ascii(305, "dermap");
  ifd.Ascii(306, metadata.date_time);
  ifd.Short(33421, {2, 2});       // CFARepeatPatternDim
  ifd.Byte(33422, {0, 1, 1, 2});  // CFAPattern RGGB
}

void AddDngTags(Directory& ifd, const DngMetadata& metadata) {
  ifd.Byte(50706, {1, 4, 0, 0});  // DNGVersion
  ifd.Byte(50707, {1, 1, 0, 0});  // DNGBackwardVersion
  ifd.Ascii(50708, "dermap simulated");
  ifd.Byte(50710, {0, 1, 2});  // CFAPlaneColor
  ifd.Short(50711, {1});       // CFALayout: rectangular
  ifd.Short(50714, {static_cast<std::uint32_t>(metadata.black_level)});
  ifd.Short(50717, {kDngWhiteLevel});
  // ColorMatrix1, which readers insist on: XYZ to linear sRGB, IEC 61966-2-1. Nothing here is measured by
  // colour.
  constexpr std::array<double, 9> kXyzToSrgb{3.2406, -1.5372, -0.4986, -0.9689, 1.8758,
                                             0.0415, 0.0557,  -0.2040, 1.0570};
  ifd.SignedRational(50721, kXyzToSrgb);
  ifd.Rational(50728, metadata.as_shot_neutral);
  ifd.Ascii(50735, metadata.serial);
  ifd.Short(50778, {21});  // CalibrationIlluminant1: D65
}

}  // namespace

std::vector<std::byte> EncodeDng(const Plane<std::uint16_t>& bayer, const DngMetadata& metadata) {
  assert(bayer.width() % 2 == 0 && !bayer.empty());
  const Bytes pixels = Pack12(bayer);
  const Directory exif = ExifDirectory(metadata);
  Directory ifd;
  AddImageTags(ifd, bayer, metadata, static_cast<std::uint32_t>(pixels.size()));
  AddDngTags(ifd, metadata);
  ifd.Long(34665,
           0);  // the EXIF directory's offset and the strip's, known once both directories have their size
  ifd.Long(273, 0);
  constexpr std::uint32_t kHeaderSize = 8;
  const std::uint32_t exif_at = kHeaderSize + ifd.Size();
  ifd.Long(34665, exif_at);
  ifd.Long(273, exif_at + exif.Size());

  Bytes file{std::byte{'I'}, std::byte{'I'}};
  Append16(file, 42);
  Append32(file, kHeaderSize);
  ifd.Write(file);
  assert(file.size() == exif_at);
  exif.Write(file);
  file.insert(file.end(), pixels.begin(), pixels.end());
  return file;
}

}  // namespace dermap
