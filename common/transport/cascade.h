// SPDX-License-Identifier: Apache-2.0
// The paper's convolution: 18 separable blurs at full resolution, each made from the last [D08 4.3].
// The slow twin of every faster engine: kept plain, and as fast as plain can be.
#pragma once

#include <map>
#include <utility>

#include "common/transport/convolver.h"

namespace dermap {

class CascadeConvolver : public Convolver {
 public:
  CascadeConvolver(const Domain& domain, double pixel_size_mm, Border border);
  void Convolve(const PlaneF& input, std::span<const ConvolutionTarget> targets) override;
  void ConvolveTransposed(const PlaneF& result, const ResponseWeights& weights, PlaneF& input) override;

 private:
  const SymmetricKernel& Kernel(int from, int to);

  Domain domain_;
  double pixel_size_mm_;
  SeparableBlur blur_;
  PlaneF blurred_;
  std::map<std::pair<int, int>, SymmetricKernel> kernels_;
};

}  // namespace dermap
