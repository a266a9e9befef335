// SPDX-License-Identifier: Apache-2.0
// Separable convolution of a plane with a symmetric kernel.
#pragma once

#include <vector>

#include "common/core/image.h"
#include "common/transport/gaussian_kernel.h"

namespace dermap {

// What lies outside the plane.
enum class Border {
  kZero,    // nothing, and what is blurred out is lost
  kMirror,  // the plane mirrored at its edge, over and over (half-sample symmetry): nothing is lost, a
            // constant stays
};

// Position of sample `i`, anywhere, in a mirrored row of n samples.
int MirroredIndex(int i, int n) noexcept;

// Keeps its scratch memory between calls; one a thread.
class SeparableBlur {
 public:
  explicit SeparableBlur(Border border) : border_(border) {}
  // `out` may be `in`; it is given the shape of `in` if it has another.
  void Apply(const PlaneF& in, const SymmetricKernel& kernel, PlaneF& out);

 private:
  void Rows(const PlaneF& in, const SymmetricKernel& kernel);
  void Columns(const SymmetricKernel& kernel, PlaneF& out);

  Border border_;
  PlaneF rows_done_;
  std::vector<float> padded_row_;
  std::vector<float> zero_row_;
  std::vector<const float*> before_, after_;
};

// out[x] = taps[0] middle[x] + sum_{k=1..radius} taps[k] (before[k-1][x] + after[k-1][x]): the loop that all
// blurs spend their time in. `out` overlaps no input.
void SumPairs(const float* middle, const float* const* before, const float* const* after, const float* taps,
              int radius, int n, float* out) noexcept;

}  // namespace dermap
