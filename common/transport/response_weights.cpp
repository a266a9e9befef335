// SPDX-License-Identifier: Apache-2.0
// Weights of the Gaussians in every pixel.
#include "common/transport/response_weights.h"

#include <algorithm>
#include <cmath>

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

// d position / d mu_a, where mu_a is within the tables: they are spaced by its logarithm.
float PositionSlope(float mu_a) {
  static const auto steps = static_cast<float>(1.0 / std::log(TableMuA(1) / TableMuA(0)));
  return mu_a > static_cast<float>(kTableMinMuA) && mu_a < static_cast<float>(kTableMaxMuA) ? steps / mu_a
                                                                                            : 0.0f;
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

DERMAP_KERNEL
void InterpolateColumnSlope(const float* column, const int* index, const float* slope, int n,
                            float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) out[x] = slope[x] * (column[index[x] + 1] - column[index[x]]);
}

void TablePositions::Set(const PlaneF& mu_a, const Domain& domain) {
  PlaneF whole;
  ReplicateOutwards(mu_a, domain, whole);
  SetWhole(whole, false);
}

void TablePositions::SetWhole(const PlaneF& mu_a, bool slopes) {
  if (!index.SameShape(mu_a)) index = Plane<int>(mu_a.width(), mu_a.height());
  EnsureShape(fraction, mu_a.width(), mu_a.height());
  if (slopes) EnsureShape(slope, mu_a.width(), mu_a.height());
  lowest = kTableSize;
  highest = 0;
  const float* values = mu_a.data();
  for (std::size_t i = 0; i < mu_a.size(); ++i) {
    const TablePosition position = PositionInTable(values[i]);
    index.data()[i] = position.index;
    fraction.data()[i] = position.fraction;
    lowest = std::min(lowest, position.index);
    highest = std::max(highest, position.index + 1);
    if (slopes) slope.data()[i] = PositionSlope(values[i]);
  }
}

void ResponseWeights::Set(const ProfileTable& table, const TablePositions& positions, const Region& region,
                          bool slopes) {
  SetTwo(table, table, positions, region, region, slopes);
}

void ResponseWeights::SetTwo(const ProfileTable& table, const ProfileTable& outside,
                             const TablePositions& positions, const Region& region, const Region& patch,
                             bool slopes) {
  region_ = region;
  for (int gaussian = 0; gaussian < kGaussianCount; ++gaussian) {
    const Column inner = ColumnOf(table, gaussian);
    const Column outer = &outside == &table ? inner : ColumnOf(outside, gaussian);
    active_[gaussian] = IsActive(inner, positions) || IsActive(outer, positions);
    if (!active_[gaussian]) continue;
    EnsureShape(planes_[gaussian], region.width, region.height);
    if (slopes) EnsureShape(slopes_[gaussian], region.width, region.height);
    for (int y = 0; y < region.height; ++y) {
      const int* index = positions.index.Row(y + region.y);
      const auto fill = [&](const Column& column, int from, int to) {  // x of the domain
        if (to <= from) return;
        InterpolateColumn(column.data(), index + from, positions.fraction.Row(y + region.y) + from, to - from,
                          planes_[gaussian].Row(y) + from - region.x);
        if (slopes)
          InterpolateColumnSlope(column.data(), index + from, positions.slope.Row(y + region.y) + from,
                                 to - from, slopes_[gaussian].Row(y) + from - region.x);
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

int ResponseWeights::ActiveBefore(int gaussian) const {
  do --gaussian;
  while (gaussian >= 0 && !active_[gaussian]);
  return gaussian;
}

}  // namespace dermap
