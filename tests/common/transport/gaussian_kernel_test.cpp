// SPDX-License-Identifier: Apache-2.0
// Kernels against Bessel functions, sampled Gaussians and the sum of variances.
#include "common/transport/gaussian_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace dermap {
namespace {

double Transfer(const SymmetricKernel& kernel, double omega) {
  double sum = kernel[0];
  for (std::size_t k = 1; k < kernel.size(); ++k)
    sum += 2.0 * kernel[k] * std::cos(omega * static_cast<double>(k));
  return sum;
}

// Lindeberg, "Scale-space for discrete signals", 1990: the discrete Gaussian is exp(-t) I_n(t). I_n from the
// standard library, the kernel from a transfer function: two ways that share nothing.
TEST(GaussianKernel, IsLindebergsDiscreteGaussianBelowHalfAPixelSquared) {
  for (const double t : {1e-4, 0.01, 0.1165, 0.3, 0.49}) {
    const SymmetricKernel kernel = BlurKernel(0.0, t);
    for (std::size_t n = 0; n < kernel.size(); ++n) {
      EXPECT_NEAR(kernel[n], std::exp(-t) * std::cyl_bessel_i(static_cast<double>(n), t), 1e-5)
          << "t " << t << " n " << n;
    }
  }
}

// The Gaussian's own formula; from half a pixel squared up it may be sampled.
TEST(GaussianKernel, IsTheSampledGaussianAboveHalfAPixelSquared) {
  for (const double v : {0.6, 1.0, 5.0, 400.0}) {
    const SymmetricKernel kernel = BlurKernel(0.0, v);
    double sum = 1.0;
    for (int n = 1; n < 400; ++n) sum += 2.0 * std::exp(-0.5 * n * n / v);
    for (std::size_t n = 0; n < kernel.size(); ++n) {
      EXPECT_NEAR(kernel[n], std::exp(-0.5 * static_cast<double>(n * n) / v) / sum, 2e-5)
          << "v " << v << " n " << n;
    }
  }
}

// "Successive blurs sum variances" [D08 4.3]: the transfer function after the whole cascade is the widest
// Gaussian's, for the paper's 18 variances at the pixel sizes of a fit's levels.
TEST(GaussianKernel, CascadeReachesEveryVarianceOfThePaper) {
  for (const double pixel_size_mm : {0.005, 7.5 / 256, 7.5 / 32}) {
    double last = 0.0;
    std::vector<double> product(64, 1.0);
    for (int i = 0; i < 18; ++i) {
      const double v = 0.0001 * std::exp2(i) / (pixel_size_mm * pixel_size_mm);
      const SymmetricKernel kernel = BlurKernel(last, v);
      EXPECT_NEAR(KernelVariance(kernel), v - last, 2e-3 * v)
          << "Gaussian " << i << " of pixel " << pixel_size_mm;
      for (std::size_t j = 0; j < product.size(); ++j) {
        const double omega = std::numbers::pi * static_cast<double>(j) / static_cast<double>(product.size());
        product[j] *= Transfer(kernel, omega);
        EXPECT_NEAR(product[j], GaussianTransfer(v, omega), 2e-4) << "Gaussian " << i << " at " << omega;
      }
      last = v;
    }
  }
}

// exp(-v omega^2 / 2), the transform of a continuous Gaussian, which both forms must approach at low
// frequency.
TEST(GaussianKernel, TransferIsThatOfTheContinuousGaussianAtLowFrequency) {
  for (const double v : {0.01, 0.3, 0.7, 4.0, 100.0}) {
    for (const double omega : {0.0, 0.05, 0.1, 0.2}) {
      EXPECT_NEAR(GaussianTransfer(v, omega), std::exp(-0.5 * v * omega * omega),
                  3e-3 * v * omega * omega + 1e-12);
    }
  }
}

// By definition: light is neither made nor lost.
TEST(GaussianKernel, SumsToOne) {
  for (const double v : {0.001, 0.2, 2.0, 7000.0}) EXPECT_NEAR(Transfer(BlurKernel(0.0, v), 0.0), 1.0, 1e-5);
}

}  // namespace
}  // namespace dermap
