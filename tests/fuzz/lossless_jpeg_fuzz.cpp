// SPDX-License-Identifier: Apache-2.0
// Any bytes as a lossless JPEG, dealt out into strips whose widths the first bytes say: a frame, or none.
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "calibrate/strips.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kSaid = 3;
  constexpr long long kMostValues = 1 << 20;
  if (size < kSaid) return 0;
  auto jpeg = dermap::LosslessJpeg::Open(std::span(data, size).subspan(kSaid));
  if (!jpeg) return 0;
  const long long values = static_cast<long long>(jpeg->shape().lines) * jpeg->values_per_line();
  if (values > kMostValues) return 0;
  dermap::StripLayout strips{1 + data[0] % 4, 1 + data[1], 1 + data[2], 1};
  const int width = (strips.strips - 1) * strips.width + strips.last_width;
  strips.height = static_cast<int>(values / width);
  if (!dermap::Fills(*jpeg, strips)) strips = {1, 0, jpeg->values_per_line(), jpeg->shape().lines};
  std::vector<std::uint16_t> frame(static_cast<std::size_t>(values));
  const std::size_t pitch = frame.size() / static_cast<std::size_t>(strips.height);
  if (!dermap::Fills(*jpeg, strips)) std::abort();
  dermap::DecodeStrips(*jpeg, strips, pitch, frame.data());
  return 0;
}
