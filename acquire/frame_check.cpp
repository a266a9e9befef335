// SPDX-License-Identifier: Apache-2.0
// Decoding by LibRaw.
#include "acquire/frame_check.h"

#include <libraw/libraw.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

namespace dermap {
namespace {

constexpr int kSaturationMargin_dn = 2;

std::vector<std::uint16_t> ActiveArea(const LibRaw& raw) {
  const auto& s = raw.imgdata.sizes;
  std::vector<std::uint16_t> values;
  values.reserve(static_cast<std::size_t>(s.width) * s.height);
  for (int y = 0; y < s.height; ++y) {
    const auto* row = raw.imgdata.rawdata.raw_image +
                      static_cast<std::size_t>(y + s.top_margin) * (s.raw_pitch / sizeof(std::uint16_t)) +
                      s.left_margin;
    values.insert(values.end(), row, row + s.width);
  }
  return values;
}

}  // namespace

FrameCheck CheckFrame(const RawFrame& frame) {
  FrameCheck check;
  const auto raw =
      std::make_unique<LibRaw>(LIBRAW_OPIONS_NO_DATAERR_CALLBACK);  // silent; we ask for the count
  const auto failed = [&](int code, const char* what) {
    if (code == LIBRAW_SUCCESS) return false;
    check.problem = std::string(what) + ": " + libraw_strerror(code);
    return true;
  };
  if (frame.bytes.empty()) {
    check.problem = "the file is empty";
    return check;
  }
  // LibRaw only reads from the buffer; its interface lacks the const.
  if (failed(raw->open_buffer(const_cast<std::byte*>(frame.bytes.data()), frame.bytes.size()),
             "not a raw file")) {
    return check;
  }
  if (failed(raw->unpack(), "does not decode")) return check;
  if (raw->imgdata.rawdata.raw_image == nullptr) {
    check.problem = "holds no mosaic of photosites";
    return check;
  }
  // LibRaw fills what a truncated file lacks; it only counts it.
  if (raw->error_count() > 0) {
    check.problem = "is truncated or damaged";
    return check;
  }
  std::vector<std::uint16_t> values = ActiveArea(*raw);
  check.decodes = true;
  check.width_px = raw->imgdata.sizes.width;
  check.height_px = raw->imgdata.sizes.height;
  const auto white = static_cast<int>(raw->imgdata.color.maximum);
  const auto black = static_cast<int>(raw->imgdata.color.black + raw->imgdata.color.cblack[0]);
  const auto saturated =
      std::count_if(values.begin(), values.end(), [&](int v) { return v >= white - kSaturationMargin_dn; });
  check.saturated_share = static_cast<double>(saturated) / static_cast<double>(values.size());
  const auto percentile = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), percentile, values.end());
  check.level =
      std::max(0, static_cast<int>(*percentile) - black) / static_cast<double>(std::max(1, white - black));
  return check;
}

}  // namespace dermap
