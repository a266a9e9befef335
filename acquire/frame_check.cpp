// SPDX-License-Identifier: Apache-2.0
// Decoding by LibRaw.
#include "acquire/frame_check.h"

#include <libraw/libraw.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/files/raw_guard.h"

namespace dermap {
namespace {

constexpr int kSaturationMargin_dn = 2;

// Empty where there is none.
std::string SizeProblem(const libraw_image_sizes_t& s) {
  const std::string problem =
      RawSizeProblem({s.width, s.height, s.raw_width, s.raw_height, s.left_margin, s.top_margin});
  return problem.empty() ? "" : "has " + problem;
}

// Photosites of the active area, row by row, with their range.
struct Mosaic {
  explicit Mosaic(LibRaw& raw)
      : width(raw.imgdata.sizes.width),
        height(raw.imgdata.sizes.height),
        white(raw.imgdata.color.maximum),
        black(static_cast<double>(raw.imgdata.color.black) + raw.imgdata.color.cblack[0]) {
    const auto& s = raw.imgdata.sizes;
    values.reserve(static_cast<std::size_t>(width) * height);
    for (int y = 0; y < height; ++y) {
      const auto* row = raw.imgdata.rawdata.raw_image +
                        static_cast<std::size_t>(y + s.top_margin) * (s.raw_pitch / sizeof(std::uint16_t)) +
                        s.left_margin;
      values.insert(values.end(), row, row + width);
    }
    for (int i = 0; i < 4; ++i) channels[i] = raw.COLOR(i / 2, i % 2) % 4;
  }
  double Share(double value) const { return std::max(0.0, value - black) / std::max(1.0, white - black); }
  // 0 red, 1 green, 2 blue.
  int Channel(int x, int y) const {
    return channels[y % 2 * 2 + x % 2] == 3 ? 1 : channels[y % 2 * 2 + x % 2];
  }

  int width, height;
  double white, black;
  std::array<int, 4> channels{};
  std::vector<std::uint16_t> values;
};

CardLevel ReadCard(const Mosaic& m, const std::array<double, 4>& region) {
  std::array<double, 3> sum{}, count{};
  const int left = static_cast<int>(std::ceil(region[0] * m.width)),
            top = static_cast<int>(std::ceil(region[1] * m.height));
  const int right = std::min(m.width, static_cast<int>((region[0] + region[2]) * m.width));
  const int bottom = std::min(m.height, static_cast<int>((region[1] + region[3]) * m.height));
  for (int y = std::max(0, top); y < bottom; ++y) {
    for (int x = std::max(0, left); x < right; ++x) {
      const auto c = static_cast<std::size_t>(m.Channel(x, y));
      sum[c] += m.values[static_cast<std::size_t>(y) * m.width + x];
      count[c] += 1.0;
    }
  }
  CardLevel card{};
  for (std::size_t c = 0; c < 3; ++c) card[c] = count[c] > 0.0 ? m.Share(sum[c] / count[c]) : 0.0;
  return card;
}

void Measure(Mosaic& m, FrameCheck& check) {
  auto& values = m.values;
  check.size = {m.width, m.height};
  const auto saturated =
      std::count_if(values.begin(), values.end(), [&](int v) { return v >= m.white - kSaturationMargin_dn; });
  check.saturated_share = static_cast<double>(saturated) / static_cast<double>(values.size());
  const auto bins = static_cast<int>(check.histogram.size());
  for (const int v : values) {
    ++check.histogram[static_cast<std::size_t>(std::min(bins - 1, static_cast<int>(m.Share(v) * bins)))];
  }
  const auto percentile = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), percentile, values.end());
  check.level = m.Share(*percentile);
}

}  // namespace

FrameCheck CheckFrame(const RawFrame& frame, const std::array<double, 4>& card_region) {
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
  if (!SurvivesLibRaw(frame.bytes)) {
    check.problem = "is damaged where it names its camera";
    return check;
  }
  raw->imgdata.params.max_raw_memory_mb = kMostRawMemory_mb;
  // LibRaw only reads from the buffer; its interface lacks the const.
  if (failed(raw->open_buffer(const_cast<std::byte*>(frame.bytes.data()), frame.bytes.size()),
             "not a raw file")) {
    return check;
  }
  check.problem = SizeProblem(raw->imgdata.sizes);
  if (!check.problem.empty()) return check;
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
  check.problem = SizeProblem(raw->imgdata.sizes);  // LibRaw may learn more as it decodes
  if (!check.problem.empty()) return check;
  Mosaic mosaic(*raw);
  check.decodes = true;
  check.iso = raw->imgdata.other.iso_speed;
  check.exposure_ms = 1000.0 * raw->imgdata.other.shutter;
  if (card_region[2] > 0.0) check.card = ReadCard(mosaic, card_region);
  Measure(mosaic, check);
  return check;
}

}  // namespace dermap
