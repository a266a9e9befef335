// SPDX-License-Identifier: Apache-2.0
// The separable convolution against its definition.
#include "common/transport/blur.h"

#include <gtest/gtest.h>

#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

// Every tap of the two-dimensional kernel on its own: the definition, in double.
PlaneF Dense(const PlaneF& in, const SymmetricKernel& kernel, Border border) {
  PlaneF out(in.width(), in.height());
  const int radius = static_cast<int>(kernel.size()) - 1;
  const auto at = [&](int x, int y) -> double {
    const bool inside = x >= 0 && y >= 0 && x < in.width() && y < in.height();
    if (border == Border::kZero && !inside) return 0.0;
    // Mirrored at the edge between two samples: -1 is 0, -2 is 1, n is n - 1, and again from there.
    const auto fold = [](int i, int n) {
      while (i < 0 || i >= n) i = i < 0 ? -1 - i : 2 * n - 1 - i;
      return i;
    };
    return in(fold(x, in.width()), fold(y, in.height()));
  };
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      double sum = 0.0;
      for (int j = -radius; j <= radius; ++j) {
        for (int i = -radius; i <= radius; ++i)
          sum += at(x + i, y + j) * kernel[std::abs(i)] * kernel[std::abs(j)];
      }
      out(x, y) = static_cast<float>(sum);
    }
  }
  return out;
}

// The definition of a convolution; sizes that are no multiple of anything, a kernel wider than the plane.
TEST(SeparableBlur, IsTheConvolutionWithTheProductKernel) {
  const PlaneF in = Noise(45, 37, 1, 0.0f, 1.0f);
  for (const Border border : {Border::kZero, Border::kMirror}) {
    SeparableBlur blur(border);
    for (const double variance : {0.1, 2.0, 40.0, 200.0}) {
      const SymmetricKernel kernel = BlurKernel(0.0, variance);
      PlaneF out;
      blur.Apply(in, kernel, out);
      EXPECT_LT(Compare(out, Dense(in, kernel, border)).relative_max, 2e-6) << "variance " << variance;
    }
  }
}

// The same numbers whether or not the result overwrites its source.
TEST(SeparableBlur, WorksInPlace) {
  const PlaneF in = Noise(70, 33, 2, -1.0f, 1.0f);
  const SymmetricKernel kernel = BlurKernel(0.0, 3.0);
  SeparableBlur blur(Border::kMirror);
  PlaneF out, in_place = in;
  blur.Apply(in, kernel, out);
  blur.Apply(in_place, kernel, in_place);
  for (std::size_t i = 0; i < in.size(); ++i) ASSERT_EQ(out.data()[i], in_place.data()[i]);
}

// A mirrored border loses nothing: the mean stays, and a constant stays a constant.
TEST(SeparableBlur, MirrorConservesLight) {
  const PlaneF in = Noise(40, 40, 3, 0.0f, 1.0f);
  PlaneF out;
  SeparableBlur(Border::kMirror).Apply(in, BlurKernel(0.0, 500.0), out);
  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < in.size(); ++i) before += in.data()[i], after += out.data()[i];
  EXPECT_NEAR(after / before, 1.0, 1e-6);
  SeparableBlur(Border::kMirror).Apply(PlaneF(9, 7, 0.25f), BlurKernel(0.0, 500.0), out);
  for (const float value : out.values()) EXPECT_NEAR(value, 0.25f, 1e-6);
}

// Half-sample symmetry: ... 1 0 | 0 1 2 | 2 1 0 | 0 1 ...
TEST(SeparableBlur, MirroredIndexFoldsAgainAndAgain) {
  const int expected[] = {2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1, 2};
  for (int i = -6; i < 6; ++i) EXPECT_EQ(MirroredIndex(i + 3, 3), expected[i + 6]) << i + 3;
  EXPECT_EQ(MirroredIndex(-7, 3), 0);
}

}  // namespace
}  // namespace dermap
