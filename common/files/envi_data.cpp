// SPDX-License-Identifier: Apache-2.0
// Values of ENVI data files.
#include "common/files/envi_data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <system_error>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/exr_file.h"
#include "common/files/text.h"

namespace dermap {
namespace {

static_assert(std::endian::native == std::endian::little, "values are read and written without swapping");

struct DataType {
  int code;
  std::size_t bytes;
};
constexpr std::array<DataType, 7> kDataTypes{{{1, 1}, {2, 2}, {3, 4}, {4, 4}, {5, 8}, {12, 2}, {13, 4}}};

std::size_t BytesOf(int data_type) {
  for (const DataType& type : kDataTypes) {
    if (type.code == data_type) return type.bytes;
  }
  return 0;
}

template <class T>
float ValueAt(const std::byte* at, bool swap) {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return static_cast<float>(std::bit_cast<T>(bytes));
}

template <class T>
void FillPlanes(const std::byte* data, const EnviLayout& layout, std::vector<PlaneF>& planes) {
  const std::size_t samples = static_cast<std::size_t>(layout.samples);
  const std::size_t lines = static_cast<std::size_t>(layout.lines);
  const std::size_t bands = planes.size();
  // Distance, in values, between neighbours along each axis.
  std::size_t x_step = 1, y_step = samples, band_step = samples * lines;
  if (layout.interleave == Interleave::kBil) {
    band_step = samples;
    y_step = samples * bands;
  } else if (layout.interleave == Interleave::kBip) {
    band_step = 1;
    x_step = bands;
    y_step = samples * bands;
  }
  for (std::size_t band = 0; band < bands; ++band) {
    for (std::size_t y = 0; y < lines; ++y) {
      const std::byte* first = data + (band * band_step + y * y_step) * sizeof(T);
      float* row = planes[band].Row(static_cast<int>(y));
      for (std::size_t x = 0; x < samples; ++x) {
        row[x] = ValueAt<T>(first + x * x_step * sizeof(T), layout.big_endian);
      }
    }
  }
}

Interleave ReadInterleave(const EnviHeader& header) {
  const std::string name = LowerCase(header.Text("interleave").value_or("bsq"));
  if (name == "bsq") return Interleave::kBsq;
  if (name == "bil") return Interleave::kBil;
  if (name == "bip") return Interleave::kBip;
  throw InputError(header.file() + ": 'interleave' is \"" + Shorten(name, 40) +
                   "\"; expected bsq, bil or bip");
}

}  // namespace

EnviLayout ReadEnviLayout(const EnviHeader& header) {
  constexpr long long kAny = 1'000'000'000;
  EnviLayout layout;
  const long long samples = header.RequiredInteger("samples", 1, kAny);
  const long long lines = header.RequiredInteger("lines", 1, kAny);
  const long long bands = header.RequiredInteger("bands", 1, kAny);
  CheckImageSize(header.file(), samples, lines, bands);
  layout.samples = static_cast<int>(samples);
  layout.lines = static_cast<int>(lines);
  layout.bands = static_cast<int>(bands);
  layout.header_offset = header.Integer("header offset", 0, 0, kAny);
  layout.data_type = static_cast<int>(header.RequiredInteger("data type", 1, 15));
  if (BytesOf(layout.data_type) == 0) {
    throw InputError(header.file() + ": 'data type' is " + std::to_string(layout.data_type) +
                     "; expected 1, 2, 3, 12 or 13 (integers), 4 (float32) or 5 (float64)");
  }
  layout.interleave = ReadInterleave(header);
  layout.big_endian = header.Integer("byte order", 0, 0, 1) == 1;
  return layout;
}

std::filesystem::path FindEnviData(const std::filesystem::path& header_path) {
  std::filesystem::path stem = header_path;
  stem.replace_extension();  // name.hdr -> name; name.img.hdr -> name.img
  std::error_code ignored;
  for (const char* extension :
       {"", ".img", ".dat", ".raw", ".bsq", ".bil", ".bip", ".bin", ".IMG", ".DAT", ".RAW"}) {
    std::filesystem::path candidate = stem;
    candidate += extension;
    if (std::filesystem::is_regular_file(candidate, ignored)) return candidate;
  }
  throw InputError(header_path.string() + ": the data file is not beside the header; expected " +
                   stem.string() + " with .img, .dat, .raw, .bsq, .bil, .bip, .bin or no extension");
}

std::vector<PlaneF> ReadEnviPlanes(const std::filesystem::path& data_path, const EnviLayout& layout) {
  CheckReadable(data_path);
  const auto values = static_cast<std::uintmax_t>(layout.samples) *
                      static_cast<std::uintmax_t>(layout.lines) * static_cast<std::uintmax_t>(layout.bands);
  const auto needed = static_cast<std::uintmax_t>(layout.header_offset) + values * BytesOf(layout.data_type);
  const auto found = std::filesystem::file_size(data_path);
  if (found < needed) {
    throw InputError(data_path.string() + " has " + std::to_string(found) + " bytes, its header asks for " +
                     std::to_string(needed) +
                     "; the file is incomplete or the header wrong; remedy: restore it from a copy");
  }
  const std::vector<std::byte> bytes = ReadBinaryFile(data_path);
  const std::byte* data = bytes.data() + layout.header_offset;
  std::vector<PlaneF> planes(static_cast<std::size_t>(layout.bands), PlaneF(layout.samples, layout.lines));
  switch (layout.data_type) {
    case 1:
      FillPlanes<std::uint8_t>(data, layout, planes);
      break;
    case 2:
      FillPlanes<std::int16_t>(data, layout, planes);
      break;
    case 3:
      FillPlanes<std::int32_t>(data, layout, planes);
      break;
    case 4:
      FillPlanes<float>(data, layout, planes);
      break;
    case 5:
      FillPlanes<double>(data, layout, planes);
      break;
    case 12:
      FillPlanes<std::uint16_t>(data, layout, planes);
      break;
    default:
      FillPlanes<std::uint32_t>(data, layout, planes);
      break;
  }
  return planes;
}

std::string EncodeEnviPlanes(const std::vector<PlaneF>& planes) {
  std::string bytes;
  for (const PlaneF& plane : planes) {
    bytes.append(reinterpret_cast<const char*>(plane.data()), plane.size() * sizeof(float));
  }
  return bytes;
}

}  // namespace dermap
