// SPDX-License-Identifier: Apache-2.0
// The weights w_i(mu_a(x)) of one response in every pixel: what the gather form reads at the point where
// light exits.
#pragma once

#include <array>

#include "common/core/image.h"
#include "common/optics/profile_table.h"
#include "common/transport/domain.h"

namespace dermap {

// Where each pixel's mu_a lies in the tables; looked up once, then shared by all responses of the layer.
struct TablePositions {
  Plane<int> index;
  PlaneF fraction;
  int lowest = 0;   // smallest index
  int highest = 0;  // largest index that an interpolation reads

  // `mu_a` on the patch, 1/mm; the margin repeats its edge.
  void Set(const PlaneF& mu_a, const Domain& domain);
};

// A Gaussian whose weight never exceeds this over the absorptions of a scene is left out.
inline constexpr float kNegligibleWeight = 1e-7f;

class ResponseWeights {
 public:
  // The response `table` in `region`, its pixels' positions given.
  void Set(const ProfileTable& table, const TablePositions& positions, const Region& region);
  // The same, but with `outside` wherever the pixel is not in `patch`.
  void SetTwo(const ProfileTable& table, const ProfileTable& outside, const TablePositions& positions,
              const Region& region, const Region& patch);

  const Region& region() const { return region_; }
  bool active(int gaussian) const { return active_[gaussian]; }
  // Of the region's shape; only where active.
  const PlaneF& plane(int gaussian) const { return planes_[gaussian]; }

 private:
  Region region_;
  std::array<bool, kGaussianCount> active_{};
  std::array<PlaneF, kGaussianCount> planes_;
};

// out[x] = (1 - fraction[x]) column[index[x]] + fraction[x] column[index[x] + 1]
void InterpolateColumn(const float* column, const int* index, const float* fraction, int n,
                       float* out) noexcept;

}  // namespace dermap
