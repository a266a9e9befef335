// SPDX-License-Identifier: Apache-2.0
// Any bytes as a raw file: a frame of bounded size, or an InputError.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "calibrate/raw_frame.h"
#include "common/core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int file = memfd_create("frame", 0);
  if (file < 0) std::abort();
  if (write(file, data, size) == static_cast<ssize_t>(size)) {
    try {
      const auto frame = dermap::ReadBayerFrame("/proc/self/fd/" + std::to_string(file));
      if (frame.values.size() > 200'000'000U || !(frame.white_level > frame.black_level)) std::abort();
    } catch (const dermap::InputError&) {
    }
  }
  close(file);
  return 0;
}
