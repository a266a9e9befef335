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
  PlaneF slope;     // of the position, by mu_a, mm; only if asked for
  int lowest = 0;   // smallest index
  int highest = 0;  // largest index that an interpolation reads

  // `mu_a` on the patch, 1/mm; the margin repeats its edge.
  void Set(const PlaneF& mu_a, const Domain& domain);
  // `mu_a` on the whole domain. `slopes`: whether derivatives will be asked for.
  void SetWhole(const PlaneF& mu_a, bool slopes);
};

// A Gaussian whose weight never exceeds this over the absorptions of a scene is left out.
inline constexpr float kNegligibleWeight = 1e-7f;

class ResponseWeights {
 public:
  // The response `table` in `region`, its pixels' positions given. `slopes`: derivatives by mu_a as well.
  void Set(const ProfileTable& table, const TablePositions& positions, const Region& region,
           bool slopes = false);
  // The same, but with `outside` wherever the pixel is not in `patch`.
  void SetTwo(const ProfileTable& table, const ProfileTable& outside, const TablePositions& positions,
              const Region& region, const Region& patch, bool slopes = false);

  const Region& region() const { return region_; }
  bool active(int gaussian) const { return active_[gaussian]; }
  // Of the region's shape; only where active.
  const PlaneF& plane(int gaussian) const { return planes_[gaussian]; }
  const PlaneF& slope(int gaussian) const { return slopes_[gaussian]; }  // its derivative by mu_a
  int ActiveBefore(int gaussian) const;                                  // the next narrower, or -1

 private:
  Region region_;
  std::array<bool, kGaussianCount> active_{};
  std::array<PlaneF, kGaussianCount> planes_, slopes_;
};

// out[x] = (1 - fraction[x]) column[index[x]] + fraction[x] column[index[x] + 1]
void InterpolateColumn(const float* column, const int* index, const float* fraction, int n,
                       float* out) noexcept;
// Its derivative by mu_a: out[x] = slope[x] (column[index[x] + 1] - column[index[x]])
void InterpolateColumnSlope(const float* column, const int* index, const float* slope, int n,
                            float* out) noexcept;

}  // namespace dermap
