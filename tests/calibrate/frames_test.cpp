// SPDX-License-Identifier: Apache-2.0
// Black subtraction and masks on frames made by hand.
#include "calibrate/frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "calibrate/spectralon.h"
#include "common/core/error.h"
#include "tests/calibrate/simulated_session.h"

namespace dermap {
namespace {

FrameRecord Record(int number, FrameRole role, double exposure_ms, int iso) {
  FrameRecord record;
  record.number = number;
  record.role = role;
  record.exposure_ms = exposure_ms;
  record.iso = iso;
  record.file = "frame " + std::to_string(number);
  return record;
}

struct Frames {
  Session session;
  std::map<int, BayerFrame> frames;
  FrameReader Reader() const {
    return [this](const FrameRecord& record) { return frames.at(record.number); };
  }
  void Add(const FrameRecord& record, Plane<std::uint16_t> values) {
    session.frames.push_back(record);
    frames[record.number] = FrameOf(std::move(values));
  }
};

Plane<std::uint16_t> Pattern(int base) {
  Plane<std::uint16_t> values(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) values(x, y) = static_cast<std::uint16_t>(base + (7 * x + 3 * y) % 5);
  }
  return values;
}

// Whole numbers in, so the difference is exact: signal = frame - mean of the black frames, 0.5 where two of
// them differ by 1.
TEST(BlackFrames, AreSubtractedExactly) {
  Frames f;
  f.Add(Record(1, FrameRole::kBlack, 10, 100), Pattern(126));
  f.Add(Record(2, FrameRole::kBlack, 10, 100), Pattern(127));
  f.Add(Record(3, FrameRole::kSkin, 10, 100), Pattern(1126));
  const BlackFrames blacks(f.session, f.Reader());
  ASSERT_EQ(blacks.levels().size(), 1u);
  EXPECT_EQ(blacks.levels()[0].frames, 2);
  EXPECT_NEAR(blacks.levels()[0].temporal_variance, 0.5, 1e-6);  // of two values that differ by 1
  const SignalFrame signal = ReadSignal(f.session.frames[2], f.Reader(), blacks);
  for (const float v : signal.signal.values()) ASSERT_EQ(v, 999.5f);
  EXPECT_TRUE(signal.notes.empty());
}

// By definition of "nearest": same ISO before same exposure.
TEST(BlackFrames, AreChosenByIsoThenExposure) {
  Frames f;
  f.Add(Record(1, FrameRole::kBlack, 10, 100), Pattern(100));
  f.Add(Record(2, FrameRole::kBlack, 40, 200), Pattern(200));
  f.Add(Record(3, FrameRole::kBlack, 10, 400), Pattern(220));
  const BlackFrames blacks(f.session, f.Reader());
  EXPECT_EQ(blacks.Find(10, 100).note, "");
  EXPECT_EQ(blacks.Find(10, 200).level->iso, 200);
  EXPECT_NE(blacks.Find(10, 200).note, "");
  EXPECT_EQ(blacks.Find(10, 800).level->iso, 400);
}

// The photosites made hot and dead here, and no others.
TEST(Masks, FindHotAndDeadPhotosites) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  Plane<std::uint16_t> black(64, 48), white(64, 48);
  for (std::size_t i = 0; i < black.size(); ++i) {
    black.data()[i] = static_cast<std::uint16_t>(std::lround(126 + 1.5 * normal(random)));
    white.data()[i] = static_cast<std::uint16_t>(std::lround(1500 + 12 * normal(random)));
  }
  black(20, 10) = 400;
  white(33, 21) = 130;  // does not answer
  white(0, 47) = 700;   // answers half, in the corner
  Frames f;
  f.Add(Record(1, FrameRole::kBlack, 10, 100), black);
  f.Add(Record(2, FrameRole::kSpectralon, 10, 100), white);
  const BlackFrames blacks(f.session, f.Reader());
  SignalFrame signal = ReadSignal(f.session.frames[1], f.Reader(), blacks);
  MarkDead(signal.signal, 2, signal.mask);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool hot = x == 20 && y == 10;
      const bool dead = (x == 33 && y == 21) || (x == 0 && y == 47);
      EXPECT_EQ((signal.mask(x, y) & kPhotositeHot) != 0, hot) << x << ", " << y;
      EXPECT_EQ((signal.mask(x, y) & kPhotositeDead) != 0, dead) << x << ", " << y;
    }
  }
}

// A saturated photosite takes the nearest ones of its own colour with it, not its other neighbours.
TEST(Masks, GrowSaturationWithinItsColour) {
  Frames f;
  f.Add(Record(1, FrameRole::kBlack, 10, 100), Plane<std::uint16_t>(64, 48, 126));
  Plane<std::uint16_t> bright(64, 48, 2000);
  bright(30, 20) = 4095;
  f.Add(Record(2, FrameRole::kSkin, 10, 100), bright);
  const BlackFrames blacks(f.session, f.Reader());
  const SignalFrame signal = ReadSignal(f.session.frames[1], f.Reader(), blacks);
  int masked = 0;
  for (const auto m : signal.mask.values()) masked += m != 0 ? 1 : 0;
  EXPECT_EQ(masked, 9);
  EXPECT_NE(signal.mask(32, 22), 0);
  EXPECT_EQ(signal.mask(31, 20), 0);
}

// The table's own value for a line, and its mean over a Gaussian for a certificate that is a straight line:
// the same.
TEST(Spectralon, CertificateIsTakenOverTheFilter) {
  const SampledSpectrum line({400.0, 700.0}, {0.90, 0.99});
  EXPECT_NEAR(CertifiedReflectance(line, {500.0, 0.0}), 0.93, 1e-12);
  EXPECT_NEAR(CertifiedReflectance(line, {500.0, 10.0}), 0.93, 1e-6);
  // A step at 500 nm: half of the filter's light on either side.
  const SampledSpectrum step({400.0, 499.999, 500.001, 700.0}, {0.0, 0.0, 1.0, 1.0});
  EXPECT_NEAR(CertifiedReflectance(step, {500.0, 10.0}), 0.5, 1e-3);
  // 5 nm to the right of it: the normal distribution's share within one half-width, 1 - erfc(sqrt(ln 2)) / 2
  // = 0.8805.
  EXPECT_NEAR(CertifiedReflectance(step, {505.0, 10.0}), 0.8805, 5e-3);
}

}  // namespace
}  // namespace dermap
