// SPDX-License-Identifier: Apache-2.0
// Cosine transforms, stencils, transforms of kernels and exponentials: what the path engine is made of.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "common/optics/profile_table.h"
#include "common/transport/paths/attenuation.h"
#include "common/transport/paths/cosine_transform.h"
#include "common/transport/paths/radial_transform.h"
#include "common/transport/paths/stencil.h"
#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

// Source: OpenCV's dct.
TEST(CosineTransform, IsOpenCvs) {
  for (const auto& [width, height] :
       {std::pair{4, 6}, std::pair{36, 20}, std::pair{104, 52}, std::pair{60, 198}}) {
    const PlaneF before = Noise(width, height, 3, -1.0f, 1.0f);
    PlaneF plane = before;
    CosineTransform transform(width, height);
    transform.Forward(plane);
    cv::Mat expected;
    cv::dct(cv::Mat(height, width, CV_32F, const_cast<float*>(before.data())), expected);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) ASSERT_NEAR(plane(x, y), expected.at<float>(y, x), 2e-5) << width;
    transform.Inverse(plane);
    for (std::size_t i = 0; i < plane.size(); ++i)
      ASSERT_NEAR(plane.data()[i], before.data()[i], 1e-5) << width;
  }
}

// Source: the transfer function that was asked for, evaluated from the taps; a convolution with a mirrored
// border multiplies a wave by it.
TEST(Stencil, HasTheTransferAskedFor) {
  const auto transfer = [](double kx, double ky) {
    const double k2 = kx * kx + ky * ky;
    return (1.0 - std::exp(-2.4 * k2) * (1.0 + 2.4 * k2)) / (1.0 + 0.3 * std::sqrt(k2));
  };
  const Stencil stencil(transfer, 7);
  const int width = 45, height = 38;
  for (const auto& [u, v] : {std::pair{0, 0}, std::pair{3, 1}, std::pair{10, 12}, std::pair{30, 7}}) {
    const double kx = std::numbers::pi * u / width, ky = std::numbers::pi * v / height;
    PlaneF wave(width, height), ones(width, height, 1.0f), sum(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        wave(x, y) = static_cast<float>(std::cos(kx * (x + 0.5)) * std::cos(ky * (y + 0.5)));
    StencilRunner runner(Border::kMirror);
    runner.AddTo(wave, stencil, &ones, sum);
    const double tolerance = std::hypot(kx, ky) < 0.5 ? 1e-3 : 1e-2;
    for (std::size_t i = 0; i < sum.size(); ++i)
      ASSERT_NEAR(sum.data()[i], transfer(kx, ky) * wave.data()[i], tolerance) << u << ' ' << v;
  }
}

// Source: a direct double loop.
TEST(Stencil, ConvolvesWithZerosOutside) {
  const Stencil stencil([](double kx, double ky) { return std::cos(kx) * std::cos(ky) + 0.3; }, 3);
  const PlaneF in = Noise(37, 11, 5, 0.0f, 1.0f), factor = Noise(37, 11, 6, 0.0f, 1.0f);
  PlaneF sum(37, 11, 2.0f);
  StencilRunner(Border::kZero).AddTo(in, stencil, &factor, sum);
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 37; ++x) {
      double expected = 0.0;
      for (int dy = -3; dy <= 3; ++dy) {
        for (int dx = -3; dx <= 3; ++dx) {
          if (x + dx < 0 || x + dx >= 37 || y + dy < 0 || y + dy >= 11) continue;
          const auto& row = stencil.rows()[std::abs(dy)];
          if (std::abs(dx) < static_cast<int>(row.size())) expected += row[std::abs(dx)] * in(x + dx, y + dy);
        }
      }
      ASSERT_NEAR(sum(x, y), 2.0 + factor(x, y) * expected, 1e-5);
    }
  }
}

// Source: std::exp.
TEST(Attenuate, IsTheExponential) {
  const PlaneF mu_a = Noise(31, 7, 1, 0.0f, 60.0f);
  PlaneF out;
  Attenuate(mu_a, 1.3, out);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double expected = std::exp(-1.3 * mu_a.data()[i]);
    ASSERT_NEAR(out.data()[i] / expected, 1.0, 1e-5);
  }
}

// Source: a function that is known everywhere, given at the tables' frequencies.
TEST(RadialTransform, IsTheFunctionBetweenItsSamples) {
  std::vector<float> values;
  for (const double k : TableFrequencies_per_mm())
    values.push_back(static_cast<float>(1.0 / (1.0 + 0.02 * k * k)));
  const RadialTransform transform(values);
  for (const double k : {0.0, 0.03, 0.7, 5.0, 31.0, 99.0})
    EXPECT_NEAR(transform.At(RadialTransform::PositionOf(k)), 1.0 / (1.0 + 0.02 * k * k), 2e-5) << k;
}

}  // namespace
}  // namespace dermap
