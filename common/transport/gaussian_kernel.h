// SPDX-License-Identifier: Apache-2.0
// Gaussians on a pixel grid: what a blur should do at each spatial frequency, and short symmetric kernels
// that do it. Variances are per axis in px^2, frequencies in radians per pixel.
#pragma once

#include <functional>
#include <vector>

namespace dermap {

// One half of a symmetric kernel whose sum is 1: taps[0] in the middle, taps[k] at +k and at -k.
using SymmetricKernel = std::vector<float>;

// Share of a kernel's weight that truncation may cut away; the rest is rescaled to sum 1.
inline constexpr double kKernelTail = 1e-5;

// Transfer function of the Gaussian of [D08 eq. 4] on the grid. From kSampledVariance_px2 up it is that of
// the sampled Gaussian, which is then right to 1 % of its variance or better. Below, sampling is wrong (the
// centre tap takes all) and Lindeberg's discrete Gaussian exp(-v) I_n(v) takes its place: positive, and its
// variance is v exactly.
inline constexpr double kSampledVariance_px2 = 0.5;
double GaussianTransfer(double variance_px2, double omega);

// Kernel with this (real, even, 1 at 0) transfer function. `variance_px2`, the kernel's own, bounds the
// search for its radius.
SymmetricKernel KernelFromTransfer(const std::function<double(double omega)>& transfer, double variance_px2);

// Kernel that makes the Gaussian of variance `to` out of the one of variance `from` (0: out of the image
// itself): "successive blurs sum variances" [D08 4.3]. Exact in the sense that the transfer functions'
// quotient is.
SymmetricKernel BlurKernel(double from_px2, double to_px2);

// Variance that a kernel adds, px^2.
double KernelVariance(const SymmetricKernel& kernel);

}  // namespace dermap
