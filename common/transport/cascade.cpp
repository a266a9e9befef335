// SPDX-License-Identifier: Apache-2.0
// The paper's cascade of separable blurs.
#include "common/transport/cascade.h"

namespace dermap {

CascadeConvolver::CascadeConvolver(const Domain& domain, double pixel_size_mm, Border border)
    : domain_(domain), pixel_size_mm_(pixel_size_mm), blur_(border), blurred_(domain.width, domain.height) {}

// The blur that leads from Gaussian `from` (-1: the input) to Gaussian `to`.
const SymmetricKernel& CascadeConvolver::Kernel(int from, int to) {
  SymmetricKernel& kernel = kernels_[{from, to}];
  if (kernel.empty()) {
    kernel = BlurKernel(from < 0 ? 0.0 : GaussianVariance_px2(from, pixel_size_mm_),
                        GaussianVariance_px2(to, pixel_size_mm_));
  }
  return kernel;
}

void CascadeConvolver::Convolve(const PlaneF& input, std::span<const ConvolutionTarget> targets) {
  assert(input.SameShape(domain_.width, domain_.height));
  ClearTargets(targets);
  int last = -1;
  for (int gaussian = 0; gaussian < kGaussianCount; ++gaussian) {
    if (!AnyActive(targets, gaussian)) continue;
    blur_.Apply(last < 0 ? input : blurred_, Kernel(last, gaussian), blurred_);
    last = gaussian;
    for (const ConvolutionTarget& target : targets) {
      if (!target.weights->active(gaussian)) continue;
      const Region& region = target.weights->region();
      for (int y = 0; y < region.height; ++y) {
        AccumulateRow(target.weights->plane(gaussian).Row(y), blurred_.Row(y + region.y) + region.x,
                      region.width, target.out->Row(y));
      }
    }
  }
}

}  // namespace dermap
