// SPDX-License-Identifier: Apache-2.0
// Taking planes apart into octaves and putting them together.
#include "fit/octaves.h"

#include <gtest/gtest.h>

#include <random>

namespace dermap {
namespace {

PlaneF RandomPlane(int width, int height) {
  PlaneF plane(width, height);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> values(-1.0f, 1.0f);
  for (float& value : plane.values()) value = values(random);
  return plane;
}

constexpr GridShape kShapes[] = {{16, 16}, {13, 9}, {5, 4}, {1, 7}, {2, 1}, {1, 1}};

TEST(Octaves, HalvingUndoesDoubling) {
  for (const GridShape shape : kShapes) {
    const PlaneF means = RandomPlane((shape.width + 1) / 2, (shape.height + 1) / 2);
    const PlaneF again = Halve(Double(means, shape));
    for (std::size_t i = 0; i < means.size(); ++i)
      EXPECT_NEAR(again.data()[i], means.data()[i], 2e-6) << shape.width << " x " << shape.height;
  }
}

TEST(Octaves, DetailHasNoMeansAndIsItsOwnDetail) {
  for (const GridShape shape : kShapes) {
    const PlaneF detail = DetailOf(RandomPlane(shape.width, shape.height));
    const PlaneF means = Halve(detail);
    for (const float mean : means.values()) EXPECT_NEAR(mean, 0.0f, 2e-6);
    const PlaneF again = DetailOf(detail);
    for (std::size_t i = 0; i < detail.size(); ++i) EXPECT_NEAR(again.data()[i], detail.data()[i], 4e-6);
  }
}

TEST(Octaves, ALinearRampHasNoDetailInside) {
  PlaneF ramp(32, 32);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) ramp(x, y) = 0.1f * x - 0.05f * y;
  const PlaneF detail = DetailOf(ramp);
  for (int y = 8; y < 24; ++y)
    for (int x = 8; x < 24; ++x) EXPECT_NEAR(detail(x, y), 0.0f, 1e-4);
}

TEST(Octaves, SumsKeepTheTotal) {
  for (const GridShape shape : kShapes) {
    double before = 0.0, after = 0.0;
    const PlaneF plane = RandomPlane(shape.width, shape.height);
    for (const float value : plane.values()) before += value;
    const PlaneF sums = HalveSum(plane);
    for (const float value : sums.values()) after += value;
    EXPECT_NEAR(before, after, 1e-5);
  }
}

double Dot(const PlaneF& a, const PlaneF& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a.data()[i]) * b.data()[i];
  return sum;
}

TEST(Octaves, TransposesAreTransposed) {
  for (const GridShape shape : kShapes) {
    const PlaneF fine = RandomPlane(shape.width, shape.height);
    const PlaneF coarse = RandomPlane((shape.width + 1) / 2, (shape.height + 1) / 2);
    EXPECT_NEAR(Dot(Halve(fine), coarse), Dot(fine, HalveTransposed(coarse, shape)), 1e-5);
    EXPECT_NEAR(Dot(Double(coarse, shape), fine), Dot(coarse, DoubleTransposed(fine)), 2e-5);
    EXPECT_NEAR(Dot(DetailOf(fine), fine), Dot(fine, DetailTransposed(fine)), 2e-5);
  }
}

TEST(Octaves, ShapesEndInOnePixel) {
  const auto shapes = OctaveShapes(256, 130);
  EXPECT_EQ(shapes.size(), 9u);
  EXPECT_EQ(shapes.back().size(), 1u);
  EXPECT_EQ(shapes[1].height, 65);
}

}  // namespace
}  // namespace dermap
