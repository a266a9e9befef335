// SPDX-License-Identifier: Apache-2.0
// Photon transfer against frames whose gain and read noise are put in here.
#include "calibrate/noise_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/core/error.h"

namespace dermap {
namespace {

constexpr PixelRegion kCard{20, 20, 120, 160};

struct Truth {
  double gain, read_dn;
};

// A textured, unevenly lit card with fixed offsets: everything but noise must drop out.
SignalFrame CardFrame(double flash, int iso, const Truth& truth, const BlackReference& black, unsigned seed) {
  SignalFrame frame;
  frame.record.iso = iso;
  frame.black = &black;
  frame.signal = PlaneF(160, 200);
  frame.mask = MaskPlane(160, 200, 0);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 160; ++x) {
      const double colour[] = {90.0, 700.0, 700.0, 300.0};
      const double texture = 1.0 + 0.1 * std::sin(0.9 * x) * std::cos(1.3 * y) + 0.002 * x;
      const double level = flash * colour[LatticeOf(x, y)] * texture;
      const double sigma = std::sqrt(truth.gain * level + truth.read_dn * truth.read_dn);
      frame.signal(x, y) = static_cast<float>(std::round(level + sigma * normal(random)));
    }
  }
  return frame;
}

// Gain and read noise put in (rounding adds 1/12 to the read variance); 24000 differences: 2 % of the
// variance.
TEST(NoiseModel, RecoversGainAndReadNoise) {
  BlackReference black;
  black.frames = 1000;
  std::vector<PhotonTransferPoint> points;
  for (unsigned k = 0; k < 4; ++k) {
    const auto a = CardFrame(1.0 + 0.05 * k, 100, {0.08, 1.2}, black, 10 + k);
    const auto b = CardFrame(1.0, 100, {0.08, 1.2}, black, 20 + k);
    const auto own = PhotonTransfer(a, b, 1, kCard);
    EXPECT_EQ(own.size(), 4u);
    points.insert(points.end(), own.begin(), own.end());
  }
  const auto models = FitNoise(points);
  ASSERT_EQ(models.size(), 1u);
  EXPECT_NEAR(models.at(100).gain, 0.08, 0.03 * 0.08);
  EXPECT_NEAR(models.at(100).read_variance, 1.44 + 1.0 / 12.0, 0.6);
}

// A point of black frames pins the read noise far better: 2 / sqrt(samples).
TEST(NoiseModel, TakesTheReadNoiseFromRepeatedBlackFrames) {
  BlackReference black;
  black.frames = 1000;
  auto points = PhotonTransfer(CardFrame(1.0, 100, {0.08, 1.2}, black, 1),
                               CardFrame(1.0, 100, {0.08, 1.2}, black, 2), 1, kCard);
  points.push_back({100, 0.0, 1.0, 1.50, 100000});
  const auto models = FitNoise(points);
  EXPECT_NEAR(models.at(100).read_variance, 1.50, 0.02);
  EXPECT_NEAR(models.at(100).gain, 0.08, 0.05 * 0.08);
}

// Gains in the ratio of the ISO values: a few points of a rare ISO borrow from the others, within 3 %.
TEST(NoiseModel, LendsStrengthFromIsoToIso) {
  std::vector<PhotonTransferPoint> points;
  for (int i = 1; i <= 10; ++i) points.push_back({100, 200.0 * i, 2.0, 0.08 * 200.0 * i + 2.0, 5000});
  points.push_back({200, 500.0, 2.0, 1.2 * (0.16 * 500.0 + 4.0), 100});  // 20 % too high, known to 14 %
  points.push_back({200, 900.0, 2.0, 1.2 * (0.16 * 900.0 + 4.0), 100});
  const auto models = FitNoise(points);
  EXPECT_NEAR(models.at(100).gain, 0.08, 0.01 * 0.08);
  EXPECT_NEAR(models.at(200).gain, 0.16, 0.03 * 0.16);
}

// By definition: noise that does not grow with light is not a raw frame's.
TEST(NoiseModel, RefusesNoiseThatFallsWithLight) {
  const std::vector<PhotonTransferPoint> points{{100, 100.0, 2.0, 50.0, 5000}, {100, 900.0, 2.0, 5.0, 5000}};
  EXPECT_THROW(FitNoise(points), InputError);
}

// By definition: frames of one kind alone tell nothing of shot noise.
TEST(NoiseModel, IsEmptyForBlackFramesAlone) {
  EXPECT_TRUE(FitNoise({{100, 0.0, 1.0, 1.5, 1000}}).empty());
}

}  // namespace
}  // namespace dermap
