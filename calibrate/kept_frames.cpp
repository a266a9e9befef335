// SPDX-License-Identifier: Apache-2.0
// A frame is handed out once: whoever takes it frees its place.
#include "calibrate/kept_frames.h"

#include <utility>

namespace dermap {
namespace {

std::size_t BytesOf(const BayerFrame& frame) {
  return frame.values.size() * sizeof(std::uint16_t);
}

}  // namespace

BayerFrame KeptFrames::Peek(const FrameRecord& record) {
  BayerFrame frame = read_(record);
  const std::lock_guard lock(mutex_);
  if (bytes_ + BytesOf(frame) <= most_bytes_ && kept_.emplace(record.number, frame).second)
    bytes_ += BytesOf(frame);
  return frame;
}

BayerFrame KeptFrames::Take(const FrameRecord& record) {
  {
    const std::lock_guard lock(mutex_);
    if (auto kept = kept_.extract(record.number)) {
      bytes_ -= BytesOf(kept.mapped());
      return std::move(kept.mapped());
    }
  }
  return read_(record);
}

}  // namespace dermap
