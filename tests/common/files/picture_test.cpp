// SPDX-License-Identifier: Apache-2.0
// False colours, scales, ticks, PNG and annotated maps.
#include "common/files/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numeric>
#include <opencv2/imgcodecs.hpp>

#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

int Distance(const Rgb8& a, const Rgb8& b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

// matplotlib, _cm_listed.py: first and last entries of viridis, magma and inferno.
TEST(Picture, ColourMapsHaveTheirPublishedEnds) {
  EXPECT_LE(Distance(ColourAt(ColourMap::kViridis, 0.0), {68, 1, 84}), 1);
  EXPECT_LE(Distance(ColourAt(ColourMap::kViridis, 1.0), {253, 231, 37}), 1);
  EXPECT_LE(Distance(ColourAt(ColourMap::kMagma, 0.0), {0, 0, 4}), 1);
  EXPECT_LE(Distance(ColourAt(ColourMap::kMagma, 1.0), {252, 253, 191}), 1);
  EXPECT_LE(Distance(ColourAt(ColourMap::kInferno, 1.0), {252, 255, 164}), 1);
}

// IEC 61966-2-1: linear 0.5 is encoded as 188 (187.5 rounded, from the 256-entry palette 188).
TEST(Picture, GrayIsAPhotograph) {
  EXPECT_LE(Distance(ColourAt(ColourMap::kGray, 0.5), {188, 188, 188}), 1);
}

// The contract of picture.h: blue below, near white in the middle, red above, equally dark at both ends.
TEST(Picture, DivergingMapIsBalanced) {
  const Rgb8 low = ColourAt(ColourMap::kDiverging, 0.0), middle = ColourAt(ColourMap::kDiverging, 0.5);
  const Rgb8 high = ColourAt(ColourMap::kDiverging, 1.0);
  EXPECT_GT(low[2], low[0]);
  EXPECT_GT(high[0], high[2]);
  for (const std::uint8_t c : middle) EXPECT_GT(c, 230);
}

// The contract of colour.h: the colour of missing pixels is in none of the maps.
TEST(Picture, MissingColourIsDistinct) {
  for (const ColourMap map : {ColourMap::kGray, ColourMap::kViridis, ColourMap::kMagma, ColourMap::kInferno,
                              ColourMap::kDiverging}) {
    for (int i = 0; i <= 255; ++i) EXPECT_GT(Distance(ColourAt(map, i / 255.0), kMissingColour), 40);
  }
}

// Values 0 to 1000: percentile p is 10 p. An outlier must not move the scale.
TEST(Picture, RobustScaleIgnoresOutliersAndMissingValues) {
  std::vector<float> values(1001);
  std::iota(values.begin(), values.end(), 0.0f);
  EXPECT_NEAR(RobustScale(values).low, 10.0, 1.0);
  EXPECT_NEAR(RobustScale(values).high, 990.0, 1.0);
  values[500] = 1e9f;
  values[501] = NAN;
  values[502] = INFINITY;
  EXPECT_NEAR(RobustScale(values).high, 990.0, 2.0);
  EXPECT_NEAR(SymmetricScale(values).low, -SymmetricScale(values).high, 0.0);
}

// The contract of picture.h: never of zero width, [0, 1] without values.
TEST(Picture, ScaleOfUniformOrNoValuesIsUsable) {
  const std::vector<float> uniform(10, 0.25f), zero(10, 0.0f), none(3, NAN);
  EXPECT_LT(RobustScale(uniform).low, 0.25);
  EXPECT_GT(RobustScale(uniform).high, 0.25);
  EXPECT_LT(RobustScale(zero).low, RobustScale(zero).high);
  EXPECT_EQ(RobustScale(none).low, 0.0);
  EXPECT_EQ(RobustScale(none).high, 1.0);
}

// Arithmetic: a linear scale from 0 to 10 puts 0, 5, 10 at the ends and the middle.
TEST(Picture, ColouriseIsLinearAndClamps) {
  PlaneF plane(5, 1);
  const float values[] = {-3.0f, 5.0f, 10.0f, 99.0f, NAN};
  std::copy(std::begin(values), std::end(values), plane.data());
  const auto picture = Colourise(plane, ColourMap::kViridis, {0.0, 10.0});
  EXPECT_EQ(picture(0, 0), ColourAt(ColourMap::kViridis, 0.0));
  EXPECT_EQ(picture(1, 0), ColourAt(ColourMap::kViridis, 0.5));
  EXPECT_EQ(picture(2, 0), ColourAt(ColourMap::kViridis, 1.0));
  EXPECT_EQ(picture(3, 0), ColourAt(ColourMap::kViridis, 1.0));
  EXPECT_EQ(picture(4, 0), kMissingColour);
}

// Means by hand; a reduction that does not divide evenly must keep the mean of the whole.
TEST(Picture, ResizeByAreaAverages) {
  PlaneF plane(4, 2);
  std::iota(plane.values().begin(), plane.values().end(), 1.0f);  // 1 2 3 4 / 5 6 7 8
  const PlaneF half = ResizeByArea(plane, 2, 1);
  EXPECT_FLOAT_EQ(half(0, 0), 3.5f);
  EXPECT_FLOAT_EQ(half(1, 0), 5.5f);
  PlaneF wide(7, 7);
  for (std::size_t i = 0; i < wide.size(); ++i) wide.data()[i] = static_cast<float>((i * 37) % 11);
  const PlaneF small = ResizeByArea(wide, 3, 3);
  const auto mean = [](const PlaneF& p) {
    return std::accumulate(p.values().begin(), p.values().end(), 0.0) / static_cast<double>(p.size());
  };
  EXPECT_NEAR(mean(small), mean(wide), 1e-5);
}

// By hand: the mean of the three that are there; NaN where nothing is.
TEST(Picture, ResizeByAreaSkipsMissingValues) {
  PlaneF plane(4, 2, 2.0f);
  plane(0, 0) = NAN;
  plane(1, 0) = 5.0f;
  plane(2, 0) = plane(3, 0) = plane(2, 1) = plane(3, 1) = NAN;
  const PlaneF half = ResizeByArea(plane, 2, 1);
  EXPECT_FLOAT_EQ(half(0, 0), 3.0f);
  EXPECT_TRUE(std::isnan(half(1, 0)));
}

// By hand.
TEST(Picture, TicksAreRound) {
  EXPECT_EQ(NiceTicks(0.0, 10.0, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  const auto few = NiceTicks(-0.0497, 0.0497, 4);  // a step of 0.05 would leave only 0
  ASSERT_EQ(few.size(), 5u);
  EXPECT_NEAR(few[0], -0.04, 1e-12);
  EXPECT_EQ(few[2], 0.0);
  for (const double width : {1e-9, 3e-4, 0.7, 42.0, 8e6}) {
    for (const double low : {0.0, 0.33, -0.2}) {
      EXPECT_GE(NiceTicks(low * width, (low + 1.0) * width, 4).size(), 2u) << low << ' ' << width;
      EXPECT_LE(NiceTicks(low * width, (low + 1.0) * width, 4).size(), 11u) << low << ' ' << width;
    }
  }
  EXPECT_EQ(FormatTick(0.05, 0.05), "0.05");
  EXPECT_EQ(FormatTick(0.1, 0.05), "0.10");
  EXPECT_EQ(FormatTick(1200.0, 200.0), "1200");
  EXPECT_EQ(FormatTick(2e-5, 1e-5), "2e-05");
  EXPECT_EQ(FormatValue(0.12345), "0.123");
  EXPECT_EQ(FormatValue(12345.6), "12346");
  EXPECT_EQ(FormatValue(99.6, 2), "100");
  EXPECT_EQ(FormatValue(0.99999), "1");
  EXPECT_EQ(FormatValue(NAN), "-");
}

// By hand: 0.8 / 0.5; never darker than 1, never brighter than 2.
TEST(Picture, DisplayExposureIsBounded) {
  EXPECT_NEAR(DisplayExposure(std::vector<PlaneF>{PlaneF(4, 4, 0.1f), PlaneF(4, 4, 0.5f)}), 1.6, 1e-6);
  EXPECT_EQ(DisplayExposure(std::vector<PlaneF>{PlaneF(4, 4, 0.95f)}), 1.0);
  EXPECT_EQ(DisplayExposure(std::vector<PlaneF>{PlaneF(4, 4, 0.01f)}), 2.0);
}

// RFC 4648, section 10.
TEST(Picture, DataUriIsBase64) {
  const auto uri = [](std::string_view text) {
    return DataUri(std::as_bytes(std::span(text.data(), text.size())), "text/plain");
  };
  EXPECT_EQ(uri(""), "data:text/plain;base64,");
  EXPECT_EQ(uri("fo"), "data:text/plain;base64,Zm8=");
  EXPECT_EQ(uri("foobar"), "data:text/plain;base64,Zm9vYmFy");
}

// An independent reader must see the same pixels, red first.
TEST(Picture, PngKeepsEveryPixel) {
  Plane<Rgb8> picture(3, 2);
  for (std::size_t i = 0; i < picture.size(); ++i) {
    picture.data()[i] = {static_cast<std::uint8_t>(40 * i), static_cast<std::uint8_t>(255 - i), 7};
  }
  TemporaryFolder folder;
  const auto path = folder.path() / "sub" / "p.png";
  WritePng(path, picture);
  const cv::Mat bgr = cv::imread(path.string(), cv::IMREAD_COLOR);
  ASSERT_EQ(bgr.cols, 3);
  ASSERT_EQ(bgr.rows, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      const auto& c = bgr.at<cv::Vec3b>(y, x);
      EXPECT_EQ((Rgb8{c[2], c[1], c[0]}), picture(x, y));
    }
  }
}

}  // namespace
}  // namespace dermap
