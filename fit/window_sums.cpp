// SPDX-License-Identifier: Apache-2.0
// By sums over all pixels above and left of a corner.
#include "fit/window_sums.h"

#include <algorithm>
#include <vector>

namespace dermap {

PlaneF SumsAround(const PlaneF& plane, int reach) {
  const int width = plane.width(), height = plane.height();
  const std::size_t pitch = static_cast<std::size_t>(width) + 1;
  std::vector<double> corner(pitch * (static_cast<std::size_t>(height) + 1));
  const auto at = [&](int x, int y) -> double& { return corner[static_cast<std::size_t>(y) * pitch + x]; };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) at(x + 1, y + 1) = plane(x, y) + at(x, y + 1) + at(x + 1, y) - at(x, y);
  PlaneF sums(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int left = std::max(x - reach, 0), right = std::min(x + reach + 1, width);
      const int top = std::max(y - reach, 0), bottom = std::min(y + reach + 1, height);
      sums(x, y) = static_cast<float>(at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top));
    }
  return sums;
}

}  // namespace dermap
