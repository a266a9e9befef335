// SPDX-License-Identifier: Apache-2.0
// Walks the attributes of an OpenEXR header, as "OpenEXR File Layout" (openexr.com) lays them out.
#include "common/files/exr_header.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/exr_file.h"

namespace dermap {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kDeepFlag = 0x800;
constexpr std::uint32_t kMultiPartFlag = 0x1000;
constexpr std::size_t kLongestName = 255;
constexpr int kMostAttributes = 10000;
constexpr std::uint32_t kHalfType = 1;

// Types whose value has one size: the library takes that many bytes whatever the header says, so anything
// else would let it and this walk part ways.
struct FixedType {
  std::string_view name;
  std::uint32_t bytes;
};
constexpr std::array<FixedType, 20> kFixedTypes{{
    {"box2f", 16},
    {"box2i", 16},
    {"chromaticities", 32},
    {"compression", 1},
    {"double", 8},
    {"envmap", 1},
    {"float", 4},
    {"int", 4},
    {"keycode", 28},
    {"lineOrder", 1},
    {"m33f", 36},
    {"m44f", 64},
    {"rational", 8},
    {"tiledesc", 9},
    {"timecode", 8},
    {"v2f", 8},
    {"v2i", 8},
    {"v3f", 12},
    {"v3i", 12},
    {"deepImageState", 1},
}};

bool HasItsSize(const std::string& type, std::uint32_t bytes) {
  for (const FixedType& fixed : kFixedTypes) {
    if (fixed.name == type) return fixed.bytes == bytes;
  }
  return true;
}

// Little-endian reading with an end; a failed read is an empty optional.
class HeaderReader {
 public:
  explicit HeaderReader(const std::filesystem::path& path)
      : file_(path, std::ios::binary), size_(static_cast<std::int64_t>(std::filesystem::file_size(path))) {}

  std::int64_t size() const { return size_; }
  std::int64_t Position() { return file_ ? static_cast<std::int64_t>(file_.tellg()) : size_; }
  std::int64_t Left() { return size_ - Position(); }

  std::optional<std::uint32_t> Uint32() {
    std::array<unsigned char, 4> bytes{};
    if (!file_.read(reinterpret_cast<char*>(bytes.data()), bytes.size())) return std::nullopt;
    return bytes[0] | bytes[1] << 8 | bytes[2] << 16 | static_cast<std::uint32_t>(bytes[3]) << 24;
  }

  // Up to the null byte.
  std::optional<std::string> Name() {
    std::string name;
    for (char c = 0; name.size() <= kLongestName && file_.get(c);) {
      if (c == '\0') return name;
      name += c;
    }
    return std::nullopt;
  }

  void Skip(std::int64_t bytes) { file_.seekg(bytes, std::ios::cur); }
  void Seek(std::int64_t position) { file_.seekg(position); }

 private:
  std::ifstream file_;
  std::int64_t size_;
};

[[noreturn]] void ThrowDamaged(const std::string& file, const std::string& what) {
  throw InputError(file + " is damaged or incomplete (" + what +
                   "); remedy: restore it from a copy or make it again");
}

void CheckMagic(HeaderReader& reader, const std::string& file) {
  const auto magic = reader.Uint32();
  const auto version = reader.Uint32();
  if (!magic || *magic != kMagic) {
    throw InputError(file + " is not an OpenEXR file; expected a spectral stack or maps in OpenEXR");
  }
  if (!version) ThrowDamaged(file, "it ends in its header");
  if ((*version & 0xff) != 2) {
    throw InputError(file + " has version " + std::to_string(*version & 0xff) +
                     " of OpenEXR; expected version 2");
  }
  if (*version & kMultiPartFlag) {
    throw InputError(
        file +
        " is an OpenEXR file of several parts; expected one; remedy: save one part to a file of its own");
  }
  if (*version & kDeepFlag) {
    throw InputError(file + " is a deep OpenEXR image; expected a flat one; remedy: flatten it");
  }
}

// What the header says about the pixels, as far as their number of bytes goes.
struct Claims {
  double pixels = 0.0;
  double bytes_per_pixel = 0.0;
};

double ReadDataWindow(HeaderReader& reader, const std::string& file) {
  std::array<std::int64_t, 4> box{};  // x and y of the first pixel, x and y of the last
  for (std::int64_t& value : box) {
    const auto word = reader.Uint32();
    if (!word) ThrowDamaged(file, "it ends in its header");
    value = static_cast<std::int32_t>(*word);
  }
  const std::int64_t width = box[2] - box[0] + 1;
  const std::int64_t height = box[3] - box[1] + 1;
  CheckImageSize(file, width, height, 1);
  return static_cast<double>(width) * static_cast<double>(height);
}

// Each channel is a name, its type, four bytes that do not matter here, and its sampling in x and y.
double ReadChannelBytes(HeaderReader& reader, const std::string& file) {
  double bytes = 0.0;
  for (int channels = 0; channels <= kMostChannels; ++channels) {
    const auto name = reader.Name();
    if (!name) ThrowDamaged(file, "it ends in its list of channels");
    if (name->empty()) return bytes;
    const auto type = reader.Uint32();
    reader.Skip(4);
    const auto x_sampling = reader.Uint32();
    const auto y_sampling = reader.Uint32();
    if (!y_sampling) ThrowDamaged(file, "it ends in its list of channels");
    if (*x_sampling == 1 && *y_sampling == 1) bytes += *type == kHalfType ? 2.0 : 4.0;
  }
  throw InputError(file + " holds too many channels; expected at most " + std::to_string(kMostChannels));
}

// No lossless compression of OpenEXR's does better than deflate's 1032 to 1: a much shorter file cannot hold
// its pixels.
void CheckClaims(const Claims& claims, std::int64_t file_bytes, const std::string& file) {
  constexpr double kBestCompression = 2000.0;
  if (claims.pixels * claims.bytes_per_pixel > kBestCompression * static_cast<double>(file_bytes)) {
    ThrowDamaged(file, "its header promises more pixels than the file can hold");
  }
}

}  // namespace

void CheckExrHeader(const std::filesystem::path& path) {
  const std::string file = path.string();
  CheckReadable(path);
  HeaderReader reader(path);
  CheckMagic(reader, file);
  Claims claims;
  for (int attributes = 0; attributes < kMostAttributes; ++attributes) {
    const auto name = reader.Name();
    if (!name) ThrowDamaged(file, "it ends in its header");
    if (name->empty()) return CheckClaims(claims, reader.size(), file);
    const auto type = reader.Name();
    const auto size = type ? reader.Uint32() : std::nullopt;
    if (!size) ThrowDamaged(file, "it ends in its header");
    if (static_cast<std::int64_t>(*size) > reader.Left()) {
      ThrowDamaged(file, "an attribute of its header is longer than the file");
    }
    const std::int64_t next = reader.Position() + static_cast<std::int64_t>(*size);
    bool agrees = HasItsSize(*type, *size);
    if (*name == "dataWindow" && *type == "box2i" && agrees) claims.pixels = ReadDataWindow(reader, file);
    if (*type == "chlist") {
      claims.bytes_per_pixel = ReadChannelBytes(reader, file);
      agrees = reader.Position() == next;
    } else if (*type == "preview") {  // width, height, then four bytes a pixel
      const auto width = reader.Uint32();
      const auto height = reader.Uint32();
      agrees = height && 8.0 + 4.0 * *width * *height == *size;
    }
    if (!agrees) ThrowDamaged(file, "an attribute of its header is not as long as it says");
    reader.Seek(next);
  }
  ThrowDamaged(file, "its header has no end");
}

}  // namespace dermap
