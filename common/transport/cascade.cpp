// SPDX-License-Identifier: Apache-2.0
// The paper's cascade of separable blurs.
#include "common/transport/cascade.h"

#include "common/transport/plane_math.h"

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
      for (int y = 0; y < region.height; ++y)
        AccumulateTarget(target, gaussian, y, blurred_.Row(y + region.y) + region.x);
    }
  }
}

// A blur is its own transpose: the same blurs from the widest down, each Gaussian's part added on the way.
void CascadeConvolver::ConvolveTransposed(const PlaneF& result, const ResponseWeights& weights,
                                          PlaneF& input) {
  const Region& region = weights.region();
  assert(result.SameShape(region.width, region.height));
  Fill(input, domain_.width, domain_.height, 0.0f);
  for (int gaussian = kGaussianCount - 1; gaussian >= 0; --gaussian) {
    if (!weights.active(gaussian)) continue;
    for (int y = 0; y < region.height; ++y)
      AccumulateRow(weights.plane(gaussian).Row(y), result.Row(y), region.width,
                    input.Row(y + region.y) + region.x);
    blur_.Apply(input, Kernel(weights.ActiveBefore(gaussian), gaussian), input);
  }
}

}  // namespace dermap
