// SPDX-License-Identifier: Apache-2.0
// Geometry of the rendered piece of skin.
#include "common/transport/domain.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

constexpr int kMostLevels = 4;
constexpr int kCoarsestSize = 12;  // pixels that the coarsest level keeps along the shorter side, at least

int RoundUp(int value, int multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

}  // namespace

Domain MakeDomain(int patch_width, int patch_height, double margin_px) {
  const int margin = static_cast<int>(std::ceil(std::max(0.0, margin_px)));
  const int width = patch_width + 2 * margin, height = patch_height + 2 * margin;
  Domain domain;
  while (domain.levels < kMostLevels && std::min(width, height) >> (domain.levels + 1) >= kCoarsestSize) {
    ++domain.levels;
  }
  domain.width = RoundUp(width, 1 << domain.levels);
  domain.height = RoundUp(height, 1 << domain.levels);
  domain.patch = {(domain.width - patch_width) / 2, (domain.height - patch_height) / 2, patch_width,
                  patch_height};
  return domain;
}

void EnsureShape(PlaneF& plane, int width, int height) {
  if (!plane.SameShape(width, height)) plane = PlaneF(width, height);
}

void ReplicateOutwards(const PlaneF& patch, const Domain& domain, PlaneF& whole) {
  EnsureShape(whole, domain.width, domain.height);
  for (int y = 0; y < domain.height; ++y) {
    const float* from = patch.Row(std::clamp(y - domain.patch.y, 0, patch.height() - 1));
    float* to = whole.Row(y);
    float* right = to + domain.patch.x + patch.width();
    std::fill(to, to + domain.patch.x, from[0]);
    std::copy(from, from + patch.width(), to + domain.patch.x);
    std::fill(right, to + domain.width, from[patch.width() - 1]);
  }
}

void SurroundWithZeros(const PlaneF& patch, const Domain& domain, PlaneF& whole) {
  EnsureShape(whole, domain.width, domain.height);
  std::fill(whole.values().begin(), whole.values().end(), 0.0f);
  for (int y = 0; y < patch.height(); ++y) {
    const float* from = patch.Row(y);
    std::copy(from, from + patch.width(), whole.Row(y + domain.patch.y) + domain.patch.x);
  }
}

}  // namespace dermap
