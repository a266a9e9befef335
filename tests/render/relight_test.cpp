// SPDX-License-Identifier: Apache-2.0
// Light patterns: made ones against geometry, read ones against what was written.
#include "render/relight.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "common/core/error.h"
#include "common/files/maps.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

const LitPatch kPatch{50, 40, 0.1};
const std::vector<Band> kBands{{450.0, 10.0}, {550.0, 10.0}, {650.0, 10.0}};

double Sum(const PlaneF& plane) {
  return std::accumulate(plane.values().begin(), plane.values().end(), 0.0);
}

// Uniform light needs no plane: the forward model takes none as 1 everywhere.
TEST(Light, UniformIsNoPlane) {
  EXPECT_TRUE(MakeLight("uniform", kPatch, kBands).planes.empty());
}

// Geometry: period 10 px, lit first half; a period of 1.5 px lights each whole period half.
TEST(Light, StripesHaveTheirPeriod) {
  for (const char* name : {"stripes:1mm", "stripes:1.0", "stripes:1.0 mm"}) {
    const auto light = MakeLight(name, kPatch, kBands);
    ASSERT_EQ(light.planes.size(), 1u) << name;
    for (int x = 0; x < 50; ++x) EXPECT_NEAR(light.planes[0](x, 7), x % 10 < 5 ? 1.0 : 0.0, 1e-5) << x;
  }
  EXPECT_NEAR(Sum(MakeLight("stripes:0.15mm", {60, 1, 0.1}, kBands).planes[0]), 30.0, 1e-4);
}

// Area of a disc.
TEST(Light, SpotHasItsArea) {
  const auto light = MakeLight("spot:2.0mm", kPatch, kBands);
  EXPECT_NEAR(Sum(light.planes[0]) * 0.1 * 0.1, std::numbers::pi, 0.01);
  EXPECT_EQ(light.planes[0](25, 20), 1.0f);
  EXPECT_EQ(light.planes[0](0, 0), 0.0f);
  EXPECT_NEAR(Sum(MakeLight("spot:0.05mm", {51, 51, 0.1}, kBands).planes[0]), std::numbers::pi * 0.0625,
              0.02);
}

// Every wrong name gets a sentence with the right ones.
TEST(Light, RefusesRubbish) {
  for (const char* name : {"", "stripe:1mm", "stripes", "stripes:", "stripes:0mm", "stripes:-1", "stripes:x",
                           "spot:1cm", "spot:nan", "spot:inf", "uniform:1", "light.png"}) {
    EXPECT_THAT(SentenceOf<InputError>([&] { MakeLight(name, kPatch, kBands); }),
                HasSubstr("stripes:PERIODmm"))
        << name;
  }
  EXPECT_THROW(MakeLight("no_such_file.exr", kPatch, kBands), InputError);
}

// A picture of half the size, the same for all bands, whatever its only channel is called.
TEST(Light, ReadsAGrayPicture) {
  const TemporaryFolder folder;
  PlaneF plane(25, 20, 0.25f);
  WritePlanes(folder / "y.exr", {{"Y", plane}}, std::nullopt);
  WritePlanes(folder / "any.exr", {{"brightness", plane}}, std::nullopt);
  WritePlanes(folder / "two.exr", {{"Y", plane}, {"Z", PlaneF(25, 20, 9.0f)}}, std::nullopt);
  for (const char* name : {"y.exr", "any.exr", "two.exr"}) {
    const auto light = MakeLight((folder / name).string(), kPatch, kBands);
    ASSERT_EQ(light.planes.size(), 1u) << name;
    EXPECT_TRUE(light.planes[0].SameShape(50, 40));
    EXPECT_NEAR(light.planes[0](13, 17), 0.25f, 1e-6);
  }
}

// Linear between 450 and 550 nm by hand; constant beyond, with a note.
TEST(Light, ReadsOnePlaneABand) {
  const TemporaryFolder folder;
  WritePlanes(folder / "l.exr",
              {{"light.450,000000nm", PlaneF(50, 40, 1.0f)}, {"light.550,000000nm", PlaneF(50, 40, 3.0f)}},
              std::nullopt);
  const std::vector<Band> bands{{475.0, 0.0}, {550.0, 0.0}, {600.0, 0.0}};
  const auto light = MakeLight((folder / "l.exr").string(), kPatch, bands);
  ASSERT_EQ(light.planes.size(), 3u);
  EXPECT_NEAR(light.planes[0](3, 3), 1.5f, 1e-6);
  EXPECT_NEAR(light.planes[1](3, 3), 3.0f, 1e-6);
  EXPECT_NEAR(light.planes[2](3, 3), 3.0f, 1e-6);
  ASSERT_EQ(light.notes.size(), 1u);
  EXPECT_THAT(light.notes[0], HasSubstr("600 nm"));
}

// Each refusal names what was found.
TEST(Light, RefusesUnusablePictures) {
  const TemporaryFolder folder;
  const auto sentence = [&](const NamedPlanes& planes) {
    WritePlanes(folder / "l.exr", planes, std::nullopt);
    return SentenceOf<InputError>([&] { MakeLight((folder / "l.exr").string(), kPatch, kBands); });
  };
  EXPECT_THAT(sentence({{"Y", PlaneF(50, 40, -0.5f)}}), HasSubstr("-0.5"));
  EXPECT_THAT(sentence({{"Y", PlaneF(50, 40, NAN)}}), HasSubstr("nan"));
  EXPECT_THAT(sentence({{"Y", PlaneF(40, 50, 1.0f)}}), HasSubstr("40 x 50"));
  EXPECT_THAT(sentence({{"A", PlaneF(50, 40, 1.0f)}, {"B", PlaneF(50, 40, 1.0f)}}), HasSubstr("2 channels"));
  EXPECT_THAT(sentence({{"T.450,000000nm", PlaneF(50, 40, INFINITY)}}), HasSubstr("450 nm"));
}

}  // namespace
}  // namespace dermap
