// SPDX-License-Identifier: Apache-2.0
// Lines of the JPEG are not rows of a strip: values are dealt out in runs.
#include "calibrate/strips.h"

#include <algorithm>
#include <vector>

namespace dermap {
namespace {

// The place of the next value.
class Dealer {
 public:
  Dealer(const StripLayout& layout, std::size_t pitch, std::uint16_t* frame)
      : layout_(layout), pitch_(pitch), frame_(frame) {}

  void Put(std::span<const std::uint16_t> values) {
    while (!values.empty() && strip_ < layout_.strips) {
      const int width = strip_ + 1 < layout_.strips ? layout_.width : layout_.last_width;
      const auto run = std::min(values.size(), static_cast<std::size_t>(width - column_));
      const int x = strip_ * layout_.width + column_;
      std::copy_n(values.data(), run, frame_ + static_cast<std::size_t>(row_) * pitch_ + x);
      values = values.subspan(run);
      column_ += static_cast<int>(run);
      if (column_ < width) return;
      column_ = 0;
      if (++row_ == layout_.height) row_ = 0, ++strip_;
    }
  }

 private:
  StripLayout layout_;
  std::size_t pitch_;
  std::uint16_t* frame_;
  int strip_ = 0, row_ = 0, column_ = 0;
};

}  // namespace

bool Fills(const LosslessJpeg& jpeg, const StripLayout& layout) {
  if (layout.strips < 1 || layout.height < 1 || layout.last_width < 1 ||
      (layout.strips > 1 && layout.width < 1))
    return false;
  const long long width = (layout.strips - 1LL) * layout.width + layout.last_width;
  return width * layout.height == static_cast<long long>(jpeg.shape().lines) * jpeg.values_per_line();
}

bool DecodeStrips(LosslessJpeg& jpeg, const StripLayout& layout, std::size_t pitch, std::uint16_t* frame) {
  Dealer dealer(layout, pitch, frame);
  std::vector<std::uint16_t> line(static_cast<std::size_t>(jpeg.values_per_line()));
  for (int y = 0; y < jpeg.shape().lines; ++y) {
    if (!jpeg.NextLine(line)) return false;
    dealer.Put(line);
  }
  return true;
}

}  // namespace dermap
