// SPDX-License-Identifier: Apache-2.0
// Walks the attributes of an OpenEXR header, as "OpenEXR File Layout" (openexr.com) lays them out.
#include "common/files/exr_header.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
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

// Little-endian reading with an end; a failed read is an empty optional.
class HeaderReader {
 public:
  explicit HeaderReader(const std::filesystem::path& path)
      : file_(path, std::ios::binary), size_(static_cast<std::int64_t>(std::filesystem::file_size(path))) {}

  std::int64_t Left() { return file_ ? size_ - static_cast<std::int64_t>(file_.tellg()) : 0; }

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

void CheckDataWindow(HeaderReader& reader, const std::string& file) {
  std::array<std::int64_t, 4> box{};  // x and y of the first pixel, x and y of the last
  for (std::int64_t& value : box) {
    const auto word = reader.Uint32();
    if (!word) ThrowDamaged(file, "it ends in its header");
    value = static_cast<std::int32_t>(*word);
  }
  CheckImageSize(file, box[2] - box[0] + 1, box[3] - box[1] + 1, 1);
}

}  // namespace

void CheckExrHeader(const std::filesystem::path& path) {
  const std::string file = path.string();
  CheckReadable(path);
  HeaderReader reader(path);
  CheckMagic(reader, file);
  for (int attributes = 0; attributes < kMostAttributes; ++attributes) {
    const auto name = reader.Name();
    if (!name) ThrowDamaged(file, "it ends in its header");
    if (name->empty()) return;
    const auto type = reader.Name();
    const auto size = type ? reader.Uint32() : std::nullopt;
    if (!size) ThrowDamaged(file, "it ends in its header");
    if (*size > 0x7fffffffu || static_cast<std::int64_t>(*size) > reader.Left()) {
      ThrowDamaged(file, "an attribute of its header is longer than the file");
    }
    if (*name == "dataWindow" && *size == 16) {
      CheckDataWindow(reader, file);
    } else {
      reader.Skip(*size);
    }
  }
  ThrowDamaged(file, "its header has no end");
}

}  // namespace dermap
