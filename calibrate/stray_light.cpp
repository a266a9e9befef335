// SPDX-License-Identifier: Apache-2.0
// A linear equation in the share, solved again as the gray card's ratio follows.
#include "calibrate/stray_light.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

constexpr double kClear_px = 5.0;  // from the window's edge: the lens blurs skin into nearer tape
constexpr int kRounds = 4;
constexpr double kKnownTape = 1e-6;  // reflectance: a sigma of 0 is taken for this
constexpr int kFewest = 100;         // photosites of tape
constexpr double kAnyDistance = 1e9;

}  // namespace

StrayLight EstimateStrayLight(const Mosaic& mosaic, const Window& window, const FrameMeans& means,
                              const GrayCardRatio& card, double certificate,
                              const std::optional<Known>& tape_reflectance, const Known& expected) {
  RegionSignals tape;
  for (const RegionSignals& stretch :
       SumTape(mosaic, window, means, kClear_px / window.smallest_side_px, kAnyDistance))
    tape.Add(stretch);
  StrayLight result;
  result.share = expected;
  result.card_ratio = card.ratio;
  const bool seen = tape.count >= kFewest && tape.spectralon > 0.0;
  if (seen) result.tape = certificate / card.ratio * tape.skin / tape.spectralon;
  const Known tape_is = tape_reflectance.value_or(Known{});
  for (int round = 0; round < kRounds; ++round) {
    const double scale = certificate / result.card_ratio;
    const double per_share = scale * tape.skin_mean - tape_is.value * tape.spectralon_mean;
    if (seen && tape_reflectance && per_share > 0.0) {
      const double measured =
          std::max(0.0, (scale * tape.skin - tape_is.value * tape.spectralon) / per_share);
      const double sigma = std::max(tape_is.sigma, kKnownTape) * tape.spectralon / per_share;
      const double belief =
          expected.sigma * expected.sigma / (expected.sigma * expected.sigma + sigma * sigma);
      result.share = {expected.value + belief * (measured - expected.value),
                      expected.sigma * std::sqrt(1.0 - belief)};
    }
    result.card_ratio = CardRatioWithout(result.share.value, means, card);
  }
  return result;
}

double CardRatioWithout(double share, const FrameMeans& means, const GrayCardRatio& card) {
  OfKinds off_skin{}, off_white{};
  for (int i = 0; i < kMostKinds; ++i) {
    off_skin[i] = share * means.skin[i];
    off_white[i] = share * means.spectralon[i];
  }
  return card.RatioWithout(off_skin, off_white);
}

void RemoveStrayLight(double share, const FrameMeans& means, Mosaic& mosaic) {
  for (int i = 0; i < kMostKinds; ++i) {
    mosaic.skin_off[i] += share * means.skin[i];
    mosaic.spectralon_off[i] += share * means.spectralon[i];
  }
  for (int y = 0; y < mosaic.height(); ++y) {
    for (int x = 0; x < mosaic.width(); ++x) {
      const int i = KindOf(mosaic.x0 + x, mosaic.y0 + y, mosaic.period);
      mosaic.skin(x, y) -= static_cast<float>(share * means.skin[i]);
      mosaic.spectralon(x, y) -= static_cast<float>(share * means.spectralon[i]);
    }
  }
}

}  // namespace dermap
