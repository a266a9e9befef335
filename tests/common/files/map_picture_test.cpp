// SPDX-License-Identifier: Apache-2.0
// The annotated map: where its pixels and its bar lie, and that every size can be drawn.
#include "common/files/map_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

bool Near(const Rgb8& a, const Rgb8& b, int tolerance = 3) {
  return std::abs(a[0] - b[0]) <= tolerance && std::abs(a[1] - b[1]) <= tolerance &&
         std::abs(a[2] - b[2]) <= tolerance;
}

bool Contains(const Plane<Rgb8>& picture, const Rgb8& colour) {
  return std::any_of(picture.values().begin(), picture.values().end(),
                     [&](const Rgb8& c) { return Near(c, colour); });
}

// 64 pixels enlarged 8 times from the corner (20, 62) of the page (layout constants of map_picture.cpp).
TEST(MapPicture, ShowsEachPixelWhereItBelongs) {
  PlaneF plane(64, 64, 0.0f);
  plane(0, 0) = 1.0f;
  plane(63, 10) = 1.0f;
  plane(20, 63) = NAN;
  const auto page = DrawMap(
      plane,
      {.title = "t", .unit = "u", .map = ColourMap::kViridis, .scale = Scale{0.0, 1.0}, .pixel_size_mm = {}});
  const Rgb8 low = ColourAt(ColourMap::kViridis, 0.0), high = ColourAt(ColourMap::kViridis, 1.0);
  EXPECT_TRUE(Near(page(20 + 4, 62 + 4), high));
  EXPECT_TRUE(Near(page(20 + 12, 62 + 4), low));
  EXPECT_TRUE(Near(page(20 + 63 * 8 + 4, 62 + 84), high));
  EXPECT_TRUE(Near(page(20 + 20 * 8 + 4, 62 + 63 * 8 + 4), kMissingColour));
}

// The bar runs from the scale's high end at the top to its low end at the bottom.
TEST(MapPicture, BarShowsTheScale) {
  PlaneF plane(64, 64, 0.5f);
  const auto page = DrawMap(
      plane,
      {.title = "t", .unit = "u", .map = ColourMap::kMagma, .scale = Scale{0.0, 1.0}, .pixel_size_mm = {}});
  const int x = 20 + 512 + 22 + 10;
  EXPECT_TRUE(Near(page(x, 62 + 3), ColourAt(ColourMap::kMagma, 1.0), 8));
  EXPECT_TRUE(Near(page(x, 62 + 256), ColourAt(ColourMap::kMagma, 0.5), 8));
  EXPECT_TRUE(Near(page(x, 62 + 508), ColourAt(ColourMap::kMagma, 0.0), 8));
}

// The contract of map_picture.h: at most 512 px, whatever the size; a note only where pixels are missing.
TEST(MapPicture, DrawsAnySize) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{2000, 1500}, std::pair{3000, 2}, std::pair{2, 700}, std::pair{512, 512}}) {
    PlaneF plane(width, height, 0.2f);
    const auto page = DrawMap(
        plane,
        {.title = "A title", .unit = "unit", .map = ColourMap::kGray, .scale = {}, .pixel_size_mm = 0.03});
    EXPECT_LE(page.width(), 720);
    EXPECT_LE(page.height(), 640);
    EXPECT_GE(page.width(), 360);
    EXPECT_FALSE(Contains(page, kMissingColour));
  }
}

// A value beyond the scale must show beside the bar (map_picture.h): the arrow head takes the end's colour.
TEST(MapPicture, MarksValuesBeyondTheScale) {
  PlaneF plane(64, 64, 0.5f);
  const MapPicture options{
      .title = "t", .unit = "u", .map = ColourMap::kViridis, .scale = Scale{0.0, 1.0}, .pixel_size_mm = {}};
  const int middle = 20 + 512 + 22 + 10;
  const auto within = DrawMap(plane, options);
  plane(0, 0) = 7.0f;
  const auto beyond = DrawMap(plane, options);
  const auto left_edge = [&](const Plane<Rgb8>& page) { return page(middle - 9, 62 + 2); };
  EXPECT_FALSE(Near(left_edge(within), {255, 255, 255}));  // the bar's own corner
  EXPECT_TRUE(Near(left_edge(beyond), {255, 255, 255}));   // beside the arrow's tip
  EXPECT_TRUE(Near(beyond(middle, 62 + 8), ColourAt(ColourMap::kViridis, 1.0), 8));
}

}  // namespace
}  // namespace dermap
