// SPDX-License-Identifier: Apache-2.0
// Any bytes as the file that a camera gave, in the process of the daemon: a problem is told, or the frame's
// numbers are finite and its picture is there.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "acquire/daemon/frame_view.h"
#include "acquire/frame_check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  const dermap::RawFrame frame{{bytes, bytes + size}, ".dng"};
  const dermap::FrameCheck check = dermap::CheckFrame(frame, {0.1, 0.1, 0.2, 0.2});
  if (check.decodes != check.problem.empty()) std::abort();
  if (!check.decodes) return 0;
  if (!std::isfinite(check.level) || !std::isfinite(check.card[1]) || !(check.saturated_share <= 1.0))
    std::abort();
  const dermap::FrameView view = dermap::MakeFrameView(frame);
  if (view.png.empty() || !std::isfinite(view.sharpness)) std::abort();
  return 0;
}
