// SPDX-License-Identifier: Apache-2.0
// What the convolution engines share.
#include "common/transport/convolver.h"

#include <algorithm>

#include "common/core/kernel.h"
#include "common/transport/cascade.h"
#include "common/transport/plane_math.h"
#include "common/transport/pyramid.h"

namespace dermap {

double GaussianVariance_px2(int gaussian, double pixel_size_mm) {
  return GaussianVariance_mm2(gaussian) / (pixel_size_mm * pixel_size_mm);
}

DERMAP_KERNEL
void AccumulateRow(const float* weights, const float* values, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) out[x] += weights[x] * values[x];
}

void AccumulateTarget(const ConvolutionTarget& target, int gaussian, int row, const float* values) noexcept {
  const ResponseWeights& weights = *target.weights;
  const int width = weights.region().width;
  AccumulateRow(weights.plane(gaussian).Row(row), values, width, target.out->Row(row));
  if (target.slope) AccumulateRow(weights.slope(gaussian).Row(row), values, width, target.slope->Row(row));
}

bool AnyActive(std::span<const ConvolutionTarget> targets, int gaussian) noexcept {
  return std::any_of(targets.begin(), targets.end(), [gaussian](const ConvolutionTarget& target) {
    return target.weights->active(gaussian);
  });
}

void ClearTargets(std::span<const ConvolutionTarget> targets) {
  for (const ConvolutionTarget& target : targets) {
    const Region& region = target.weights->region();
    Fill(*target.out, region.width, region.height, 0.0f);
    if (target.slope) Fill(*target.slope, region.width, region.height, 0.0f);
  }
}

std::unique_ptr<Convolver> MakeConvolver(Engine engine, const Domain& domain, double pixel_size_mm,
                                         Border border) {
  switch (engine) {
    case Engine::kCascade:
      return std::make_unique<CascadeConvolver>(domain, pixel_size_mm, border);
    case Engine::kPyramid:
      return std::make_unique<PyramidConvolver>(domain, pixel_size_mm, border);
    case Engine::kLowRank:
      break;  // has no Gaussians: paths/path_light.h
  }
  assert(false);
  return nullptr;
}

}  // namespace dermap
