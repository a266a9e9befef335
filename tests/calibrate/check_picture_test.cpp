// SPDX-License-Identifier: Apache-2.0
// The picture of `calibrate --check`. Expected: lines and colours at the places that follow, by hand, from
// windows, warps and residuals made for it.
#include "calibrate/check_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

constexpr int kPanelWidth = 480, kPanelHeight = 360, kTitle = 24;
constexpr Rgb8 kOrange{255, 176, 0}, kGreen{64, 200, 120}, kRed{255, 64, 64}, kEmpty{24, 24, 28};

bool Near(Rgb8 a, Rgb8 b) {
  int off = 0;
  for (std::size_t i = 0; i < 3; ++i) off = std::max(off, std::abs(int(a[i]) - int(b[i])));
  return off < 48;
}

// A black frame of a panel's size with a window of 240 photosites, whose sides lie on the middles of pixels.
BandCalibration MadeBand(double left, double top) {
  BandCalibration band;
  band.band = {550.0, 10.0};
  band.picture = PlaneF(kPanelWidth, kPanelHeight, 0.0f);
  Window window;
  const double x0 = left + 0.5, y0 = top + 0.5, x1 = x0 + 240.0, y1 = y0 + 240.0;
  window.corners = {Point{x0, y0}, Point{x1, y0}, Point{x1, y1}, Point{x0, y1}};
  window.camera_from_unit = CameraFromUnit(window.corners);
  window.edge_uncertainty_px = 0.042;
  band.windows = {window};
  return band;
}

CalibrationResult Made(const std::vector<BandCalibration>& bands) {
  CalibrationResult result;
  result.stack.valid = PlaneF(256, 256, 1.0f);
  result.bands = bands;
  return result;
}

// Seven lines at every eighth of the window, 30 pixels apart, within its outline; nothing between them.
TEST(CheckPicture, DrawsWindowAndGridWhereTheyWereFound) {
  const auto picture = CheckPicture(Made({MadeBand(100, 60)}));
  ASSERT_EQ(picture.width(), 2 * kPanelWidth);
  ASSERT_EQ(picture.height(), kPanelHeight + kTitle);
  for (int line = 1; line < 8; ++line) {
    EXPECT_TRUE(Near(picture(100 + 30 * line, kTitle + 60 + 45), kGreen)) << "upright line " << line;
    EXPECT_TRUE(Near(picture(100 + 45, kTitle + 60 + 30 * line), kGreen)) << "level line " << line;
    EXPECT_EQ(picture(100 + 30 * line + 15, kTitle + 60 + 45), (Rgb8{0, 0, 0})) << "beside line " << line;
  }
  for (const int side : {0, 240}) {
    EXPECT_TRUE(Near(picture(100 + side, kTitle + 60 + 45), kOrange)) << side;
    EXPECT_TRUE(Near(picture(100 + 45, kTitle + 60 + side), kOrange)) << side;
  }
}

// 16 pixels of a patch of 256 are 15 photosites of a window of 240: so far the grid moves, and the window
// stays.
TEST(CheckPicture, GridFollowsTheAlignment) {
  BandCalibration band = MadeBand(100, 60);
  band.alignment.warp.p[0] = 16.0;
  const auto picture = CheckPicture(Made({band}));
  for (int line = 0; line <= 8; ++line) {
    EXPECT_TRUE(Near(picture(100 + 30 * line + 15, kTitle + 60 + 45), kGreen)) << line;
    if (line > 0 && line < 8) {
      EXPECT_EQ(picture(100 + 30 * line, kTitle + 60 + 45), (Rgb8{0, 0, 0})) << line;
    }
  }
  EXPECT_TRUE(Near(picture(100, kTitle + 60 + 45), kOrange));
}

// Two standard deviations above and below the other bands are the ends of the colours; a band that was not
// aligned has no residual. The second pair of panels stands to the right of the first.
TEST(CheckPicture, ShowsTheResidualInItsColours) {
  BandCalibration band = MadeBand(100, 60);
  band.alignment.applied = true;
  band.alignment.residual = PlaneF(60, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 60; ++x) band.alignment.residual(x, y) = x < 20 ? 2.0f : x < 40 ? 0.0f : -2.0f;
  }
  const auto picture = CheckPicture(Made({MadeBand(100, 60), band}));
  ASSERT_EQ(picture.width(), 4 * kPanelWidth);
  const auto third = [&](int k) { return picture(3 * kPanelWidth + 60 + 120 * k, kTitle + 180); };
  EXPECT_TRUE(Near(third(0), ColourAt(ColourMap::kDiverging, 1.0)));
  EXPECT_TRUE(Near(third(1), ColourAt(ColourMap::kDiverging, 0.5)));
  EXPECT_TRUE(Near(third(2), ColourAt(ColourMap::kDiverging, 0.0)));
  EXPECT_FALSE(Near(third(0), third(2)));
  EXPECT_EQ(picture(kPanelWidth + 60, kTitle + 180), kEmpty);
}

TEST(CheckPicture, SaysTheFigures) {
  BandCalibration band = MadeBand(100, 60);
  EXPECT_THAT(WindowCaption(band), HasSubstr("550 nm  window +-0.042 px"));
  EXPECT_THAT(ResidualCaption(band), HasSubstr("window alone"));
  band.alignment.applied = true;
  band.alignment.dx_px = -0.31, band.alignment.dy_px = 0.12, band.alignment.uncertainty_px = 0.03;
  EXPECT_THAT(ResidualCaption(band), HasSubstr("-0.31, 0.12 px"));
  EXPECT_THAT(ResidualCaption(band), HasSubstr("+-0.03"));
  band.dropped = true;
  EXPECT_THAT(WindowCaption(band), HasSubstr("DROPPED"));
  EXPECT_TRUE(Near(CheckPicture(Made({band}))(100, kTitle + 60 + 45), kRed));
}

// Two panels of 480 x 360 and a title of 24 for each band, two bands in a row; and something is drawn.
TEST(CheckPicture, ShowsEveryBand) {
  SimulatedSession simulated("checker.toml", {}, [](PlanConfig& plan) { plan.exposures.resize(3); });
  const auto picture = CheckPicture(CalibrateFrames(simulated.session(), simulated.Reader(), {}));
  EXPECT_EQ(picture.width(), 4 * 480);
  EXPECT_EQ(picture.height(), 2 * 384);
  int orange = 0;
  for (const Rgb8& p : picture.values())
    orange += p[0] > 200 && p[1] > 130 && p[1] < 200 && p[2] < 80 ? 1 : 0;
  EXPECT_GT(orange, 500);  // the outlines of three windows
}

}  // namespace
}  // namespace dermap
