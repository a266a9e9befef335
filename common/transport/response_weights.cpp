// SPDX-License-Identifier: Apache-2.0
// Weights of the Gaussians in every pixel.
#include "common/transport/response_weights.h"

#include <algorithm>

#include "common/core/kernel.h"

namespace dermap {
namespace {

// One Gaussian's weights over the table; the last entry stands twice, so that index + 1 always exists.
using Column = std::array<float, kTableSize + 1>;

Column ColumnOf(const ProfileTable& table, int gaussian) {
  Column column;
  for (int i = 0; i < kTableSize; ++i) column[i] = table.entries()[i][gaussian];
  column[kTableSize] = column[kTableSize - 1];
  return column;
}

bool IsActive(const Column& column, const TablePositions& positions) {
  return std::any_of(column.begin() + positions.lowest, column.begin() + positions.highest + 1,
                     [](float weight) { return weight > kNegligibleWeight; });
}

}  // namespace

DERMAP_KERNEL
void InterpolateColumn(const float* column, const int* index, const float* fraction, int n,
                       float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) {
    const float here = column[index[x]];
    out[x] = here + fraction[x] * (column[index[x] + 1] - here);
  }
}

void TablePositions::Set(const PlaneF& mu_a, const Domain& domain) {
  if (!index.SameShape(domain.width, domain.height)) index = Plane<int>(domain.width, domain.height);
  EnsureShape(fraction, domain.width, domain.height);
  const Region& patch = domain.patch;
  lowest = kTableSize;
  highest = 0;
  for (int y = 0; y < patch.height; ++y) {
    int* indices = index.Row(y + patch.y);
    float* fractions = fraction.Row(y + patch.y);
    for (int x = 0; x < patch.width; ++x) {
      const TablePosition position = PositionInTable(mu_a(x, y));
      indices[x + patch.x] = position.index;
      fractions[x + patch.x] = position.fraction;
      lowest = std::min(lowest, position.index);
      highest = std::max(highest, position.index + 1);
    }
    const int right = patch.x + patch.width;
    std::fill(indices, indices + patch.x, indices[patch.x]);
    std::fill(fractions, fractions + patch.x, fractions[patch.x]);
    std::fill(indices + right, indices + domain.width, indices[right - 1]);
    std::fill(fractions + right, fractions + domain.width, fractions[right - 1]);
  }
  for (int y = 0; y < domain.height; ++y) {
    const int from = std::clamp(y, patch.y, patch.y + patch.height - 1);
    if (from == y) continue;
    std::copy(index.Row(from), index.Row(from) + domain.width, index.Row(y));
    std::copy(fraction.Row(from), fraction.Row(from) + domain.width, fraction.Row(y));
  }
}

void ResponseWeights::Set(const ProfileTable& table, const TablePositions& positions, const Region& region) {
  SetTwo(table, table, positions, region, region);
}

void ResponseWeights::SetTwo(const ProfileTable& table, const ProfileTable& outside,
                             const TablePositions& positions, const Region& region, const Region& patch) {
  region_ = region;
  for (int gaussian = 0; gaussian < kGaussianCount; ++gaussian) {
    const Column inner = ColumnOf(table, gaussian);
    const Column outer = &outside == &table ? inner : ColumnOf(outside, gaussian);
    active_[gaussian] = IsActive(inner, positions) || IsActive(outer, positions);
    if (!active_[gaussian]) continue;
    PlaneF& plane = planes_[gaussian];
    EnsureShape(plane, region.width, region.height);
    for (int y = 0; y < region.height; ++y) {
      const int* index = positions.index.Row(y + region.y);
      const float* fraction = positions.fraction.Row(y + region.y);
      const auto fill = [&](const Column& column, int from, int to) {  // x of the domain
        if (to > from) {
          InterpolateColumn(column.data(), index + from, fraction + from, to - from,
                            plane.Row(y) + from - region.x);
        }
      };
      const int right = region.x + region.width;
      const bool in_patch = y + region.y >= patch.y && y + region.y < patch.y + patch.height;
      const int inner_from = in_patch ? std::clamp(patch.x, region.x, right) : right;
      const int inner_to = in_patch ? std::clamp(patch.x + patch.width, region.x, right) : right;
      fill(outer, region.x, inner_from);
      fill(inner, inner_from, inner_to);
      fill(outer, inner_to, right);
    }
  }
}

}  // namespace dermap
