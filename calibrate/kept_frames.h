// SPDX-License-Identifier: Apache-2.0
// Frames that two steps read: decoded once, as far as memory allows.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "calibrate/frames.h"

namespace dermap {

// Safe to use from several threads.
class KeptFrames {
 public:
  KeptFrames(const FrameReader& read, std::size_t most_bytes) : read_(read), most_bytes_(most_bytes) {}
  // Reads a frame that will be read again.
  BayerFrame Peek(const FrameRecord& record);
  // Reads it, or hands out the one that was kept.
  BayerFrame Take(const FrameRecord& record);

 private:
  const FrameReader& read_;
  std::size_t most_bytes_;
  std::mutex mutex_;
  std::map<int, BayerFrame> kept_;  // by number
  std::size_t bytes_ = 0;
};

}  // namespace dermap
