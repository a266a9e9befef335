// SPDX-License-Identifier: Apache-2.0
// Gaussian kernels designed on the transform's side.
#include "common/transport/gaussian_kernel.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace dermap {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
// From here on a sampled Gaussian's aliases are below 1e-17: quotients of such Gaussians are Gaussians again.
constexpr double kNoAliasVariance_px2 = 2.0;
constexpr double kWidestRadius_sigma = 6.0;  // beyond it a Gaussian holds 2e-9

// Poisson's sum: the transform of a sampled Gaussian is the Gaussian's own, repeated every 2 pi.
double SampledTransfer(double variance_px2, double omega) {
  double at_omega = 0.0, at_zero = 0.0;
  for (int period = -3; period <= 3; ++period) {
    const double shift = kTwoPi * period;
    at_omega += std::exp(-0.5 * variance_px2 * (omega + shift) * (omega + shift));
    at_zero += std::exp(-0.5 * variance_px2 * shift * shift);
  }
  return at_omega / at_zero;
}

// Cuts where less than kKernelTail is left on both sides together, and makes the sum 1.
SymmetricKernel Truncated(const std::vector<double>& half) {
  double tail = 0.0;
  std::size_t radius = half.size() - 1;
  while (radius > 0) {
    tail += 2.0 * std::abs(half[radius]);
    if (tail > kKernelTail) break;
    --radius;
  }
  double sum = half[0];
  for (std::size_t k = 1; k <= radius; ++k) sum += 2.0 * half[k];
  SymmetricKernel kernel(radius + 1);
  for (std::size_t k = 0; k <= radius; ++k) kernel[k] = static_cast<float>(half[k] / sum);
  return kernel;
}

SymmetricKernel SampledKernel(double variance_px2) {
  const int radius = static_cast<int>(std::ceil(kWidestRadius_sigma * std::sqrt(variance_px2))) + 1;
  std::vector<double> half(radius + 1);
  const double scale = 1.0 / std::sqrt(kTwoPi * variance_px2);
  for (int k = 0; k <= radius; ++k) half[k] = scale * std::exp(-0.5 * k * k / variance_px2);
  return Truncated(half);
}

}  // namespace

double GaussianTransfer(double variance_px2, double omega) {
  if (variance_px2 < kSampledVariance_px2) return std::exp(-variance_px2 * (1.0 - std::cos(omega)));
  return SampledTransfer(variance_px2, omega);
}

SymmetricKernel KernelFromTransfer(const std::function<double(double)>& transfer, double variance_px2) {
  const int radius = static_cast<int>(std::ceil(kWidestRadius_sigma * std::sqrt(variance_px2))) + 16;
  const int samples = 4 * radius;
  std::vector<double> cosine(samples), spectrum(samples / 2 + 1);
  for (int m = 0; m < samples; ++m) cosine[m] = std::cos(kTwoPi * m / samples);
  for (int m = 0; m <= samples / 2; ++m) spectrum[m] = transfer(kTwoPi * m / samples);
  std::vector<double> half(radius + 1);
  for (int k = 0; k <= radius; ++k) {
    double sum = spectrum[0] + spectrum[samples / 2] * (k % 2 == 0 ? 1.0 : -1.0);
    for (int m = 1; m < samples / 2; ++m) {
      sum += 2.0 * spectrum[m] * cosine[static_cast<std::size_t>(m) * k % samples];
    }
    half[k] = sum / samples;
  }
  return Truncated(half);
}

SymmetricKernel BlurKernel(double from_px2, double to_px2) {
  assert(from_px2 >= 0.0 && to_px2 > from_px2);
  const double added_px2 = to_px2 - from_px2;
  if (from_px2 >= kNoAliasVariance_px2 && added_px2 >= kNoAliasVariance_px2) return SampledKernel(added_px2);
  return KernelFromTransfer(
      [&](double omega) {
        const double before = from_px2 > 0.0 ? GaussianTransfer(from_px2, omega) : 1.0;
        return GaussianTransfer(to_px2, omega) / before;
      },
      added_px2);
}

double KernelVariance(const SymmetricKernel& kernel) {
  double variance = 0.0;
  for (std::size_t k = 1; k < kernel.size(); ++k) variance += 2.0 * kernel[k] * static_cast<double>(k * k);
  return variance;
}

}  // namespace dermap
