// SPDX-License-Identifier: Apache-2.0
// The bench's light, geometry and noise against closed forms.
#include "acquire/simulated/optical_bench.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/acquire/support.h"

namespace dermap {
namespace {

using acquire_test::FlatScene;
using acquire_test::SmallRig;

constexpr int kGreenAt[2] = {1, 0};  // x, y of a green photosite of RGGB

struct Moments {
  double mean = 0.0, variance = 0.0;
};

// Over the green photosites of the middle of the window, which is flat there: a square of 140 x 140.
template <class Value>
Moments GreenMoments(const Value& value) {
  double sum = 0.0, sum2 = 0.0;
  int n = 0;
  for (int y = 110 + kGreenAt[1]; y < 250; y += 2) {
    for (int x = 120 + kGreenAt[0]; x < 260; x += 2) {
      const double v = value(x, y);
      sum += v;
      sum2 += v * v;
      ++n;
    }
  }
  const double mean = sum / n;
  return {mean, (sum2 - n * mean * mean) / (n - 1)};
}

// Photon transfer (Janesick, "Photon Transfer", 2007, eq. 4.18): the difference of two frames of one
// expectation has twice the variance read^2 + signal/K, signal in DN above black and K in electrons per DN;
// conversion adds 1/12.
TEST(OpticalBench, NoiseFollowsThePhotonTransferCurve) {
  BenchConfig config = BenchConfig::Ideal();
  config.shot_noise = true;
  config.read_noise_electrons = 9.0;
  config.read_noise_dn = 1.2;
  for (const double reflectance : {0.02, 0.1, 0.4, 0.9}) {
    for (const int iso : {100, 400}) {
      const double scale = iso == 400 ? 0.2 : 1.0;  // keep clear of saturation
      const OpticalBench bench(SmallRig(), FlatScene(reflectance * scale, config));
      const Shot a{FrameRole::kSkin, 1, 10.0, iso, 1}, b{FrameRole::kSkin, 1, 10.0, iso, 2};
      const auto frame_a = bench.Expose(a), frame_b = bench.Expose(b);
      const double k = bench.sensor().ElectronsPerDn(iso);
      const double signal = GreenMoments(frame_a).mean - config.black_level_dn;
      const double expected = signal / k + std::pow(9.0 / k, 2) + 1.2 * 1.2 + 1.0 / 12.0;
      const double found =
          GreenMoments([&](int x, int y) { return double(frame_a(x, y)) - frame_b(x, y); }).variance / 2.0;
      // 4900 differences: the standard error of a variance is sqrt(2/4900) = 2 %.
      EXPECT_NEAR(found / expected, 1.0, 4 * 0.0202) << "reflectance " << reflectance << " ISO " << iso;
    }
  }
}

// Signal = white_electrons x flash x response x reflectance, averaged over the filter: arithmetic on the CSV
// files, by a plain sum over the Gaussian instead of the bench's quadrature.
TEST(OpticalBench, SignalIsTheProductOfWhatTheLightPasses) {
  const BenchConfig config = BenchConfig::Ideal();
  const OpticalBench bench(SmallRig(), FlatScene(0.37, config));
  const auto spectra = ConfigDirectory() / "spectra";
  const auto flash = ReadSpectrumCsv(spectra / "xenon_flash.csv", "relative_power");
  for (const auto& [channel, x, y] : {std::tuple{"red", 190, 180}, {"green", 191, 180}, {"blue", 191, 181}}) {
    const auto response = ReadSpectrumCsv(spectra / "camera_rgb.csv", channel);
    const double sigma = 10.0 / 2.3548;
    double sum = 0.0, weight = 0.0;
    for (double d = -4 * sigma; d <= 4 * sigma; d += 0.05) {
      const double w = std::exp(-0.5 * d * d / (sigma * sigma));
      sum += w * flash.At(540.0 + d) * response.At(540.0 + d);
      weight += w;
    }
    const double expected = config.white_electrons * 0.37 * sum / weight;
    EXPECT_NEAR(bench.ExpectedElectrons({FrameRole::kSkin, 1, 10.0, 100, 1})(x, y), expected, 3e-3 * expected)
        << channel;
  }
}

// What makes the calibration exact: skin over Spectralon, times the certificate's value, is the reflectance,
// in every photosite of the window and of any color, with vignetting, flash and lens on. Drift alone is left
// to the gray card.
TEST(OpticalBench, RatioToSpectralonIsTheReflectance) {
  BenchConfig config;
  config.motion_shift_mm = config.motion_rotation_deg = 0.0;
  const OpticalBench bench(SmallRig(), FlatScene(0.5, config));
  const auto certificate =
      ReadSpectrumCsv(ConfigDirectory() / "spectra/spectralon_99_labsphere.csv", "reflectance");
  for (const int slot : {1, 2}) {
    const Shot skin{FrameRole::kSkin, slot, 10.0, 100, 7},
        spectralon{FrameRole::kSpectralon, slot, 10.0, 100, 3};
    const auto a = bench.ExpectedElectrons(skin), b = bench.ExpectedElectrons(spectralon);
    const double drift = bench.FlashFactor(7) / bench.FlashFactor(3);
    EXPECT_GT(std::abs(drift - 1.0), 1e-4);
    const double rho = certificate.At(slot == 1 ? 540.0 : 650.0);
    for (int y = 60; y < 300; y += 7) {
      for (int x = 50; x < 330; x += 7) {
        ASSERT_NEAR(a(x, y) / b(x, y) * rho / drift, 0.5, 5e-4) << x << ' ' << y;
      }
    }
    // The gray card shows the same drift.
    EXPECT_NEAR(a(417, 180) / b(417, 180), drift, 1e-5);
  }
}

// Projection by hand: a point (u, v) of the plane tilted by 30 degrees lies at depth 400 + v sin 30 mm; focal
// length 40 px/mm x 400 mm. The top edge (v = -3.75) is nearer: half width 3.75 x 16000 / 398.125 = 150.706
// px, height 3.75 cos 30 x 16000 / 398.125 = 130.516 px; bottom: 149.300 and 129.301 px.
TEST(OpticalBench, WindowCornersLieWhereAPinholeSeesThem) {
  BenchConfig config;
  config.motion_shift_mm = config.motion_rotation_deg = 0.0;
  const OpticalBench bench(SmallRig(), FlatScene(0.5, config));
  const auto corners = bench.CornersOfShot({FrameRole::kSkin, 1, 10.0, 100, 5});
  EXPECT_NEAR(corners[0].x, 190.0 - 150.7064, 1e-3);
  EXPECT_NEAR(corners[0].y, 179.5 - 130.5156, 1e-3);
  EXPECT_NEAR(corners[1].x, 190.0 + 150.7064, 1e-3);
  EXPECT_NEAR(corners[2].x, 190.0 + 149.3001, 1e-3);
  EXPECT_NEAR(corners[2].y, 179.5 + 129.2977, 1e-3);
  EXPECT_NEAR(corners[3].x, 190.0 - 149.3001, 1e-3);
}

// The drawn window has the area of the polygon of its corners (shoelace), counted in light: white patch,
// black tape.
TEST(OpticalBench, DrawnWindowHasTheAreaOfItsCorners) {
  BenchConfig config = BenchConfig::Ideal();
  config.tape_reflectance = 0.0;
  config.motion_shift_mm = 0.3;
  config.motion_rotation_deg = 1.0;
  RigConfig rig = SmallRig();
  rig.gray_card_reflectance = 0.0;
  const OpticalBench bench(rig, FlatScene(1.0, config));
  for (const int number : {1, 2, 3}) {
    const Shot shot{FrameRole::kSkin, 1, 10.0, 100, number};
    const auto corners = bench.CornersOfShot(shot);
    double area = 0.0, cx = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const Point2 p = corners[i], q = corners[(i + 1) % 4];
      area += 0.5 * (p.x * q.y - q.x * p.y);
      cx += (p.x + q.x) * (p.x * q.y - q.x * p.y) / 6.0;
    }
    const auto e = bench.ExpectedElectrons(shot);
    // Greens of a row count for two photosites; the full light of green is that of the middle.
    double light = 0.0, moment = 0.0;
    for (int y = 0; y < e.height(); ++y) {
      for (int x = (y + 1) % 2; x < e.width(); x += 2) {
        light += 2.0 * e(x, y);
        moment += 2.0 * e(x, y) * x;
      }
    }
    EXPECT_NEAR(light / e(191, 180), area, 2e-4 * area);
    EXPECT_NEAR(moment / light, cx / area, 0.02);
  }
}

TEST(OpticalBench, PatchAndPixelsRoundTrip) {
  const PinholeView view(BenchConfig{}, 30.0);
  const Pose pose{0.2, -0.1, 0.8};
  for (const Point2 patch : {Point2{0.0, 0.0}, {7.5, 1.0}, {3.1, 7.5}, {-2.0, 9.0}}) {
    const Point2 pixel = view.PixelFromBench(BenchFromPatch(pose, 7.5, patch));
    const Point2 back = PatchFromBench(pose, 7.5, view.BenchFromPixel(pixel));
    EXPECT_NEAR(back.x, patch.x, 1e-9);
    EXPECT_NEAR(back.y, patch.y, 1e-9);
  }
}

// Each effect alone, against a bench without any: what it must change, and what it must not.
TEST(OpticalBench, EffectsCanBeSwitchedOneByOne) {
  const Shot spectralon{FrameRole::kSpectralon, 1, 10.0, 100, 4}, skin{FrameRole::kSkin, 1, 10.0, 100, 4};
  const auto electrons = [&](const BenchConfig& c, const Shot& shot) {
    return OpticalBench(SmallRig(), FlatScene(0.5, c)).ExpectedElectrons(shot);
  };
  const auto ideal = electrons(BenchConfig::Ideal(), spectralon);
  EXPECT_EQ(ideal(1, 0), ideal(471, 350));  // flat: two green photosites of opposite corners

  BenchConfig c = BenchConfig::Ideal();
  c.vignetting = 0.3;
  auto e = electrons(c, spectralon);
  EXPECT_NEAR(e(0, 0) / ideal(0, 0), 0.7, 1e-4);  // by definition, in the corner
  EXPECT_NEAR(e(240, 180) / ideal(240, 180), 1.0, 1e-4);

  c = BenchConfig::Ideal();
  c.flash_unevenness = 0.1;
  e = electrons(c, spectralon);
  // 5 mm from the flash's axis, by definition: 200 px to the left of it.
  const PinholeView view(c, 30.0);
  const Point2 p = view.PixelFromBench({0.8 - 5.0, -0.5});
  EXPECT_NEAR(e(std::lround(p.x), std::lround(p.y)) / ideal(std::lround(p.x), std::lround(p.y)), 0.9, 1e-3);

  c = BenchConfig::Ideal();
  c.flash_drift = 0.03;
  e = electrons(c, spectralon);
  const double drift = OpticalBench(SmallRig(), FlatScene(0.5, c)).FlashFactor(4);
  EXPECT_NE(drift, 1.0);
  EXPECT_NEAR(e(240, 180) / ideal(240, 180), drift, 1e-6);

  c = BenchConfig::Ideal();
  c.misfired_shots = {4};
  EXPECT_EQ(electrons(c, spectralon)(240, 180), 0.0f);

  // The lens keeps the light and softens the edge of the tape.
  const auto sharp = electrons(BenchConfig::Ideal(), skin);
  c = BenchConfig::Ideal();
  c.psf_sigma_px = 1.0;
  const auto soft = electrons(c, skin);
  EXPECT_NEAR(soft(191, 180), sharp(191, 180), 1e-3 * sharp(191, 180));
  double change = 0.0;
  for (int y = 40; y < 60; ++y) change = std::max(change, double(std::abs(soft(191, y) - sharp(191, y))));
  EXPECT_GT(change, 0.1 * sharp(191, 180));
}

// The drift's standard deviation is the one asked for: 2000 draws, standard error 1.6 %; cut at 2.5 sigma it
// is 0.98 of it.
TEST(OpticalBench, DriftAndMotionHaveTheSizeAskedFor) {
  BenchConfig config;
  config.flash_drift = 0.02;
  const OpticalBench bench(SmallRig(), FlatScene(0.5, config));
  double sum2 = 0.0, largest_shift = 0.0, largest_rotation = 0.0;
  for (int n = 1; n <= 2000; ++n) {
    sum2 += std::pow(bench.FlashFactor(n) - 1.0, 2);
    const Pose pose = bench.PoseOfShot({FrameRole::kSkin, 1, 10.0, 100, n});
    largest_shift = std::max(largest_shift, std::hypot(pose.shift_x_mm, pose.shift_y_mm));
    largest_rotation = std::max(largest_rotation, std::abs(pose.rotation_deg));
  }
  EXPECT_NEAR(std::sqrt(sum2 / 2000), 0.98 * 0.02, 0.0012);
  EXPECT_LE(largest_shift, 0.3);
  EXPECT_GT(largest_shift, 0.29);
  EXPECT_LE(largest_rotation, 1.0);
  EXPECT_GT(largest_rotation, 0.98);
  EXPECT_EQ(bench.PoseOfShot({FrameRole::kSpectralon, 1, 10.0, 100, 3}).shift_x_mm, 0.0);
}

TEST(OpticalBench, SameSeedSameFrameOtherSeedOtherFrame) {
  const Shot shot{FrameRole::kSkin, 2, 10.0, 250, 12};
  const auto frame = [&](std::uint64_t seed, int number) {
    Shot s = shot;
    s.number = number;
    const auto plane = OpticalBench(SmallRig(), FlatScene(0.5, BenchConfig{}, seed)).Expose(s);
    return std::vector<std::uint16_t>(plane.values().begin(), plane.values().end());
  };
  EXPECT_EQ(frame(3, 12), frame(3, 12));
  EXPECT_NE(frame(3, 12), frame(4, 12));
  EXPECT_NE(frame(3, 12), frame(3, 13));
}

// 126 DN, the scene's black level, within the standard error of 172800 photosites with about 1.6 DN each; and
// hot photosites stand out.
TEST(OpticalBench, BlackFrameHoldsTheBlackLevelAndHotPhotosites) {
  BenchConfig config;
  config.hot_photosites = 0;
  Shot black{FrameRole::kBlack, 3, 10.0, 100, 1};
  const auto mean_and_outliers = [&](const BenchConfig& c) {
    const auto frame = OpticalBench(SmallRig(), FlatScene(0.5, c)).Expose(black);
    double sum = 0.0;
    int outliers = 0;
    for (const auto v : frame.values()) {
      sum += v;
      outliers += v > 126 + 20;
    }
    return std::pair{sum / static_cast<double>(frame.size()), outliers};
  };
  EXPECT_NEAR(mean_and_outliers(config).first, 126.0, 0.02);
  EXPECT_EQ(mean_and_outliers(config).second, 0);
  config.hot_photosites = 12;
  EXPECT_EQ(mean_and_outliers(config).second, 12);
}

TEST(OpticalBench, SaturatesAtTheWhiteLevel) {
  const OpticalBench bench(SmallRig(), FlatScene(0.5, BenchConfig{}));
  const auto frame = bench.Expose({FrameRole::kSpectralon, 1, 10.0, 800, 3});
  EXPECT_EQ(frame(241, 180), 4095);  // green at 540 nm
}

}  // namespace
}  // namespace dermap
