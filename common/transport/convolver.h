// SPDX-License-Identifier: Apache-2.0
// A heterogeneous convolution (P * f)(x) = sum_i w_i(mu_a(x)) (G_i * f)(x) [D08 eq. 9], behind which the
// engines stand.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "common/core/image.h"
#include "common/transport/blur.h"
#include "common/transport/domain.h"
#include "common/transport/forward_model.h"
#include "common/transport/response_weights.h"

namespace dermap {

// A response and where its result goes: a plane of the shape of its region, which is overwritten.
struct ConvolutionTarget {
  const ResponseWeights* weights;
  PlaneF* out;
  PlaneF* slope =
      nullptr;  // if asked for: the result's derivative by mu_a where it leaves (needs the weights')
};

// Keeps its memory between calls; one a thread.
class Convolver {
 public:
  virtual ~Convolver() = default;
  // Convolves `input`, on the whole domain, with every target's response; they share the blurs.
  virtual void Convolve(const PlaneF& input, std::span<const ConvolutionTarget> targets) = 0;
  // The transpose of the convolution with one response: from a plane of its region to one of the whole
  // domain.
  virtual void ConvolveTransposed(const PlaneF& result, const ResponseWeights& weights, PlaneF& input) = 0;
};

std::unique_ptr<Convolver> MakeConvolver(Engine engine, const Domain& domain, double pixel_size_mm,
                                         Border border);

// Variance of Gaussian i on this grid, px^2.
double GaussianVariance_px2(int gaussian, double pixel_size_mm);

// out += weights * values, along a row.
void AccumulateRow(const float* weights, const float* values, int n, float* out) noexcept;

// What one row of an image blurred by a Gaussian adds to a target; `values` begins where the region does.
void AccumulateTarget(const ConvolutionTarget& target, int gaussian, int row, const float* values) noexcept;

// Whether any target needs this Gaussian.
bool AnyActive(std::span<const ConvolutionTarget> targets, int gaussian) noexcept;

// Gives every target's plane its region's shape and fills it with zeros.
void ClearTargets(std::span<const ConvolutionTarget> targets);

}  // namespace dermap
