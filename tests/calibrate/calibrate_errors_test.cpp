// SPDX-License-Identifier: Apache-2.0
// Sessions that lack something or hold a bad frame. Expected: by definition an InputError that names it, or a
// mask.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate/calibrate.h"
#include "common/core/error.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

// Two bands are enough here.
void TwoBands(PlanConfig& plan) {
  plan.exposures.resize(2);
}

std::string ErrorOf(const Session& session, const FrameReader& read) {
  try {
    CalibrateFrames(session, read, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

void Remove(Session& session, FrameRole role, double wavelength_nm) {
  std::erase_if(session.frames, [&](const FrameRecord& r) {
    return r.role == role && (wavelength_nm == 0.0 || r.wavelength_nm == wavelength_nm);
  });
}

TEST(CalibrateErrors, NameTheKindOfFrameThatIsMissing) {
  for (const auto& [role, wavelength_nm, expected] :
       {std::tuple{FrameRole::kBlack, 0.0, "no black frame"},
        {FrameRole::kSpectralon, 480.0, "Spectralon frame for 480 nm"},
        {FrameRole::kSkin, 0.0, "no skin frame"}}) {
    SimulatedSession simulated("gray_50.toml", {}, TwoBands);
    Remove(simulated.session(), role, wavelength_nm);
    EXPECT_THAT(ErrorOf(simulated.session(), simulated.Reader()), HasSubstr(expected));
  }
}

// A band without a skin frame is not an error: the others are calibrated, and a note names it.
TEST(CalibrateErrors, NoteABandWithoutSkinFrames) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  Remove(simulated.session(), FrameRole::kSkin, 450.0);
  const auto result = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  EXPECT_EQ(result.stack.bands.size(), 1u);
  EXPECT_THAT(result.notes, ::testing::Contains(HasSubstr("450 nm")));
}

TEST(CalibrateErrors, NameTheFrameWhoseFlashDidNotFire) {
  for (const FrameRole role : {FrameRole::kSkin, FrameRole::kSpectralon}) {
    int number = 0;
    {
      SimulatedSession all("gray_50.toml", {}, TwoBands);
      number = all.Frames(role, 480.0).at(0).number;
    }
    SimulatedSession simulated(
        "gray_50.toml", [&](Scene& scene) { scene.bench.misfired_shots = {number}; }, TwoBands);
    const std::string error = ErrorOf(simulated.session(), simulated.Reader());
    EXPECT_THAT(error, HasSubstr("frame " + std::to_string(number) + ": the flash did not fire"));
  }
}

TEST(CalibrateErrors, NameTheFrameOfAnotherSize) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto odd = simulated.Frames(FrameRole::kSkin, 480.0).at(0);
  const FrameReader read = [&, honest = simulated.Reader()](const FrameRecord& record) {
    return record.number == odd.number ? FrameOf(Plane<std::uint16_t>(320, 240, 500)) : honest(record);
  };
  EXPECT_THAT(ErrorOf(simulated.session(), read),
              AllOf(HasSubstr(odd.file), HasSubstr("320x240"), HasSubstr("480x360")));
}

// A Spectralon frame in the place of a skin frame: no tape, no window.
TEST(CalibrateErrors, NameTheFrameWithoutAWindow) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto skin = simulated.Frames(FrameRole::kSkin, 450.0).at(0);
  const auto white = simulated.Frames(FrameRole::kSpectralon, 450.0).at(0);
  const FrameReader read = [&, honest = simulated.Reader()](const FrameRecord& record) {
    return honest(record.number == skin.number ? white : record);
  };
  EXPECT_THAT(ErrorOf(simulated.session(), read), AllOf(HasSubstr(skin.file), HasSubstr("no window")));
}

TEST(CalibrateErrors, NameAGrayCardOutsideOfTheFrame) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  simulated.session().rig.gray_card_region = {0.9, 0.2, 0.2, 0.5};
  EXPECT_THAT(ErrorOf(simulated.session(), simulated.Reader()), HasSubstr("gray_card_region"));
}

// A black frame of another exposure is used, and said so.
TEST(CalibrateErrors, NoteTheNearestBlackFrame) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  // The plan's two bands share one ISO; the second is made to claim another, for which no black frame was
  // taken.
  for (FrameRecord& frame : simulated.session().frames) {
    if (frame.wavelength_nm == 480.0) frame.iso = 126;
  }
  const auto result = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  EXPECT_THAT(result.bands[1].notes, ::testing::Contains(HasSubstr("no black frame at 10 ms, ISO 126")));
  EXPECT_NEAR(result.bands[1].median_reflectance, 0.5, 0.005 * 0.5);
}

// Photosites at white within a disc of the window: those pixels must be missing or right, never wrong. The
// strongest colours are clipped (four of four photosites), so nothing is left there.
TEST(Saturation, IsMaskedWhereItHappens) {
  SimulatedSession simulated("gray_50.toml", {}, TwoBands);
  const auto skin = simulated.Frames(FrameRole::kSkin, 450.0).at(0);
  const auto corners = simulated.bench().CornersOfShot(simulated.ShotOf(skin));
  const double cx = (corners[0].x + corners[2].x) / 2, cy = (corners[0].y + corners[2].y) / 2;
  const FrameReader read = [&, honest = simulated.Reader()](const FrameRecord& record) {
    BayerFrame frame = honest(record);
    if (record.number != skin.number) return frame;
    for (int y = 0; y < frame.values.height(); ++y) {
      for (int x = 0; x < frame.values.width(); ++x) {
        if (std::hypot(x - cx, y - cy) < 20.0) frame.values(x, y) = 4095;
      }
    }
    return frame;
  };
  const auto result = CalibrateFrames(simulated.session(), read, {});
  const PlaneF& blue = result.stack.reflectance[0];
  EXPECT_TRUE(std::isnan(blue(128, 128)));
  EXPECT_FALSE(std::isnan(result.stack.reflectance[1](128, 128)));  // the other band saw nothing of it
  EXPECT_EQ(result.stack.valid(128, 128), 1.0f);
  int missing = 0;
  for (int y = 5; y < 251; ++y) {
    for (int x = 5; x < 251; ++x) {
      if (std::isnan(blue(x, y))) {
        ++missing;
      } else {
        EXPECT_NEAR(blue(x, y), 0.5, 5.0 * result.stack.sigma[0](x, y)) << x << ", " << y;
      }
    }
  }
  // The disc's share of the window's area, in pixels of the patch, and a rim of up to four photosites around
  // it.
  const double disc = 3.14159 * 20.0 * 20.0 / (300.0 * 260.0) * 65536.0;
  EXPECT_GT(missing, disc);
  EXPECT_LT(missing, disc * 1.6);
  EXPECT_GT(result.bands[0].saturated_share, 0.01);
  EXPECT_THAT(result.bands[0].notes, ::testing::Contains(HasSubstr("saturated")));
}

}  // namespace
}  // namespace dermap
