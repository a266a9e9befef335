// SPDX-License-Identifier: Apache-2.0
// Alignment against shifts that were put in.
#include "calibrate/alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dermap {
namespace {

struct Spot {
  double x, y, radius, depth;
};

std::vector<Spot> Spots() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Spot> spots;
  for (int i = 0; i < 40; ++i) {
    const double x = 256 * uniform(random), y = 256 * uniform(random);
    spots.push_back({x, y, 4 + 8 * uniform(random), 0.5 + uniform(random)});
  }
  return spots;
}

// Freckles as an analytic function, so that a shifted band is exact: spots at fixed places, deeper in blue.
double Skin(double x, double y, double depth) {
  static const std::vector<Spot> spots = Spots();
  double absorbance = 0.0;
  for (const Spot& s : spots) {
    const double d2 = ((x - s.x) * (x - s.x) + (y - s.y) * (y - s.y)) / (2 * s.radius * s.radius);
    if (d2 < 12) absorbance += s.depth * std::exp(-d2);
  }
  return 0.4 * std::exp(-depth * absorbance);
}

struct Stack {
  std::vector<PlaneF> reflectance, noise;
};

// Six bands; band i shows at x what lies at x - shift[i], with noise of 0.6 %.
Stack ShiftedBands(const std::vector<std::array<double, 2>>& shifts, double noise_share,
                   double depth_scale = 1.0) {
  Stack stack;
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (std::size_t b = 0; b < shifts.size(); ++b) {
    PlaneF plane(256, 256);
    const double depth = depth_scale * (0.7 - 0.1 * static_cast<double>(b));
    const double gain = 0.5 + 0.1 * static_cast<double>(b);  // bands differ in brightness and contrast
    for (int y = 0; y < 256; ++y) {
      for (int x = 0; x < 256; ++x) {
        const double r = gain * Skin(x - shifts[b][0], y - shifts[b][1], depth);
        plane(x, y) = static_cast<float>(r) * (1.0f + static_cast<float>(noise_share) * normal(random));
      }
    }
    PlaneF noise(256, 256);
    for (std::size_t i = 0; i < plane.size(); ++i)
      noise.data()[i] = static_cast<float>(noise_share) * plane.data()[i];
    stack.reflectance.push_back(std::move(plane));
    stack.noise.push_back(std::move(noise));
  }
  return stack;
}

// The shifts put in, relative to their mean, which alignment leaves alone; 0.1 pixels.
TEST(AlignBands, RecoversShiftsOfATenthToAWholePixel) {
  const std::vector<std::array<double, 2>> shifts{{0.1, 0.0}, {-0.3, 0.2},  {0.5, -0.7},
                                                  {0.0, 1.0}, {-1.0, -0.2}, {0, 0}};
  const Stack stack = ShiftedBands(shifts, 0.006);
  const auto bands = AlignBands(stack.reflectance, stack.noise, {}, {});
  double mean_x = 0, mean_y = 0;
  for (const auto& s : shifts) mean_x += s[0] / 6, mean_y += s[1] / 6;
  for (std::size_t b = 0; b < shifts.size(); ++b) {
    EXPECT_TRUE(bands[b].applied) << b << ": " << bands[b].note;
    EXPECT_NEAR(bands[b].dx_px, shifts[b][0] - mean_x, 0.1) << b;
    EXPECT_NEAR(bands[b].dy_px, shifts[b][1] - mean_y, 0.1) << b;
    EXPECT_NEAR(bands[b].angle_rad, 0.0, 1e-3) << b;
  }
}

// Two bands must meet in the middle, not swap places.
TEST(AlignBands, MovesTwoBandsHalfWayEach) {
  const Stack stack = ShiftedBands({{0.6, 0.0}, {-0.6, 0.0}}, 0.006);
  const auto bands = AlignBands(stack.reflectance, stack.noise, {}, {});
  EXPECT_NEAR(bands[0].dx_px, 0.6, 0.1);
  EXPECT_NEAR(bands[1].dx_px, -0.6, 0.1);
}

// By definition: noise has no structure to align by, and the window's own alignment stays.
TEST(AlignBands, LeavesBandsWithoutStructureAlone) {
  const Stack stack = ShiftedBands({{0.5, 0}, {0, 0}, {0, 0.5}}, 0.01, 0.0);
  for (const auto& band : AlignBands(stack.reflectance, stack.noise, {}, {})) {
    EXPECT_FALSE(band.applied);
    EXPECT_FALSE(band.clearly_off);
    EXPECT_EQ(band.dx_px, 0.0);
    EXPECT_THAT(band.note, ::testing::HasSubstr("window's own alignment is kept"));
  }
}

// A band that is sharply, surely elsewhere is reported as such.
TEST(AlignBands, NamesABandThatIsClearlyOff) {
  const Stack stack = ShiftedBands({{0, 0}, {0, 0}, {5.0, 0}, {0, 0}, {0, 0}, {0, 0}}, 0.006);
  const auto bands = AlignBands(stack.reflectance, stack.noise, {}, {});
  EXPECT_TRUE(bands[2].clearly_off) << bands[2].note;
  EXPECT_FALSE(bands[0].clearly_off);
}

// Skin that is sheared and bulges by a pixel between two bands: place by place to 0.1 pixels, the mean of the
// bands being left alone.
TEST(AlignBands, FollowsSkinThatStretches) {
  Stack stack = ShiftedBands({{0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}}, 0.006);
  Warp put_in;
  put_in.p[1] = 0.6;                 // x grows to the right
  put_in.p[Warp::kModes + 3] = 1.0;  // a bulge in y
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const Point d = put_in.At({(x + 0.5) / 256, (y + 0.5) / 256});
      // What lies at x of the aligned patch lies at x + d of the band; d varies slowly, so at x - d the other
      // way.
      const double r = 0.7 * Skin(x - d.x, y - d.y, 0.5);
      stack.reflectance[2](x, y) = static_cast<float>(r) * (1.0f + 0.006f * normal(random));
    }
  }
  const auto bands = AlignBands(stack.reflectance, stack.noise, {}, {});
  double worst = 0.0;
  for (int i = 1; i < 8; ++i) {
    for (int j = 1; j < 8; ++j) {
      const Point unit{i / 8.0, j / 8.0};
      const Point truth = put_in.At(unit);
      const Point found = bands[2].warp.At(unit);
      const Point other = bands[0].warp.At(unit);
      worst = std::max(worst, std::hypot(found.x - other.x - truth.x, found.y - other.y - truth.y));
    }
  }
  EXPECT_TRUE(bands[2].applied) << bands[2].note;
  EXPECT_LT(worst, 0.15);
}

// Estimated standard deviation of the shift against its scatter over noise. The estimate is cautious: it
// counts the noise as smoothed as the photosites of a camera leave it, which the white noise of this test is
// not, and the priors that hold a shift back as if they knew nothing.
TEST(AlignBands, KnowsItsUncertainty) {
  double sum = 0.0, expected = 0.0;
  constexpr int kTrials = 4;
  for (int trial = 0; trial < kTrials; ++trial) {
    Stack stack = ShiftedBands({{0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}}, 0.0, 0.25);
    std::mt19937 random(100 + static_cast<unsigned>(trial));
    std::normal_distribution<float> normal;
    for (std::size_t b = 0; b < 6; ++b) {
      for (std::size_t i = 0; i < stack.noise[b].size(); ++i) {
        stack.noise[b].data()[i] = 0.02f * stack.reflectance[b].data()[i];
        stack.reflectance[b].data()[i] += stack.noise[b].data()[i] * normal(random);
      }
    }
    for (const auto& band : AlignBands(stack.reflectance, stack.noise, {}, {})) {
      sum += (band.dx_px * band.dx_px + band.dy_px * band.dy_px) / (2 * 6 * kTrials);
      expected += band.uncertainty_px * band.uncertainty_px / (6 * kTrials);
    }
  }
  const double ratio = std::sqrt(sum / expected);
  EXPECT_GT(ratio, 0.2);
  EXPECT_LT(ratio, 1.5);
}

}  // namespace
}  // namespace dermap
