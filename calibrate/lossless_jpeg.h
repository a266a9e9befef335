// SPDX-License-Identifier: Apache-2.0
// Lossless JPEG as cameras pack photosites (ITU-T T.81, process 14): one scan, each value predicted by the
// one to its left. Written for speed; other kinds are left to LibRaw.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "calibrate/jpeg_huffman.h"

namespace dermap {

struct JpegShape {
  int lines = 0, columns = 0;
  int components = 0;  // interleaved: so many values a column
  int bits = 0;        // of a value
};

class LosslessJpeg {
 public:
  LosslessJpeg(LosslessJpeg&&) = default;
  LosslessJpeg& operator=(LosslessJpeg&&) = default;
  // None where the data are no such JPEG, or one of another kind: other predictors, restart markers, scaled
  // components, more than four of them or three.
  static std::optional<LosslessJpeg> Open(std::span<const std::uint8_t> data);

  const JpegShape& shape() const { return shape_; }
  int values_per_line() const { return shape_.columns * shape_.components; }
  // The next line, values_per_line() of them. False where the data end early, are no code, or give a value
  // beyond the depth.
  bool NextLine(std::span<std::uint16_t> values);

 private:
  static constexpr int kMostComponents = 4;

  LosslessJpeg(const JpegShape& shape, std::span<const std::uint8_t> scan)
      : shape_(shape), bytes_(WithoutStuffing(scan)), bits_(bytes_) {}
  template <int kComponents>
  unsigned Decode(std::span<std::uint16_t> values);

  JpegShape shape_;
  std::vector<std::uint8_t> bytes_;  // a move leaves them where they are
  JpegBits bits_;
  std::array<HuffmanTable, kMostComponents> tables_;  // of the components
  std::array<std::uint16_t, kMostComponents>
      line_above_{};  // its first values, which predict the next line's
};

}  // namespace dermap
