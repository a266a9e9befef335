// SPDX-License-Identifier: Apache-2.0
// Within this folder: the data file of an ENVI image, any interleave, byte order and numeric type that we
// read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/files/envi_header.h"

namespace dermap {

enum class Interleave { kBsq, kBil, kBip };  // band, line or pixel outermost to innermost

struct EnviLayout {
  int samples = 0;  // width
  int lines = 0;    // height
  int bands = 0;
  long long header_offset = 0;  // bytes before the first value
  int data_type = 4;            // ENVI's code: 4 is float32
  Interleave interleave = Interleave::kBsq;
  bool big_endian = false;

  bool IsInteger() const { return data_type != 4 && data_type != 5; }
};

// Throws InputError for what is missing, out of range or of a type that we do not read.
EnviLayout ReadEnviLayout(const EnviHeader& header);

// The data file that belongs to a header: the same name with another extension or none, or the name less
// ".hdr".
std::filesystem::path FindEnviData(const std::filesystem::path& header_path);

// All bands, in the order of the file.
std::vector<PlaneF> ReadEnviPlanes(const std::filesystem::path& data_path, const EnviLayout& layout);

// Band-sequential little-endian float32.
std::string EncodeEnviPlanes(const std::vector<PlaneF>& planes);

}  // namespace dermap
