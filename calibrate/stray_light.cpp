// SPDX-License-Identifier: Apache-2.0
// A linear equation in the share, solved again as the gray card's ratio follows.
#include "calibrate/stray_light.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

constexpr double kClear_px = 5.0;  // from the window's edge: the lens blurs skin into nearer tape
constexpr int kRounds = 4;
constexpr double kKnownTape = 1e-6;      // reflectance: a sigma of 0 is taken for this
constexpr int kFewest = 100;             // photosites of tape
constexpr double kMostPhotosites = 2e5;  // of a mosaic that are looked at, about

struct TapeSums {
  OfKinds skin{}, spectralon{}, count{};
};

TapeSums SumTape(const Mosaic& mosaic, const Window& window) {
  const Homography unit_from_camera = window.camera_from_unit.Inverse();
  const double clear = kClear_px / window.smallest_side_px;
  // Steps that share no factor with any pattern, so that all kinds are met.
  const double share = double(mosaic.width()) * mosaic.height() / kMostPhotosites;
  int step = 1;
  while (step * step < share) step += step % 6 == 1 ? 4 : 2;
  TapeSums sums;
  for (int y = 0; y < mosaic.height(); y += step) {
    for (int x = 0; x < mosaic.width(); x += step) {
      if (mosaic.mask(x, y) != 0) continue;
      const Point p =
          unit_from_camera(mosaic.lens.IdealFromPhotosites({mosaic.x0 + x + 0.5, mosaic.y0 + y + 0.5}));
      if (std::max({-p.x, -p.y, p.x - 1.0, p.y - 1.0}) < clear) continue;
      const int i = KindOf(mosaic.x0 + x, mosaic.y0 + y, mosaic.period);
      sums.skin[i] += mosaic.skin(x, y);
      sums.spectralon[i] += mosaic.spectralon(x, y);
      sums.count[i] += 1.0;
    }
  }
  return sums;
}

}  // namespace

StrayLight EstimateStrayLight(const Mosaic& mosaic, const Window& window, const FrameMeans& means,
                              const GrayCardRatio& card, double certificate,
                              const std::optional<Known>& tape_reflectance, const Known& expected) {
  const TapeSums tape = SumTape(mosaic, window);
  double skin = 0, white = 0, skin_mean = 0, white_mean = 0, count = 0;
  for (int i = 0; i < kMostKinds; ++i) {
    skin += tape.skin[i];
    white += tape.spectralon[i];
    skin_mean += tape.count[i] * means.skin[i];
    white_mean += tape.count[i] * means.spectralon[i];
    count += tape.count[i];
  }
  StrayLight result;
  result.share = expected;
  result.card_ratio = card.ratio;
  const bool seen = count >= kFewest && white > 0.0;
  if (seen) result.tape = certificate / card.ratio * skin / white;
  const Known tape_is = tape_reflectance.value_or(Known{});
  for (int round = 0; round < kRounds; ++round) {
    const double scale = certificate / result.card_ratio;
    const double per_share = scale * skin_mean - tape_is.value * white_mean;
    if (seen && tape_reflectance && per_share > 0.0) {
      const double measured = std::max(0.0, (scale * skin - tape_is.value * white) / per_share);
      const double sigma = std::max(tape_is.sigma, kKnownTape) * white / per_share;
      const double belief =
          expected.sigma * expected.sigma / (expected.sigma * expected.sigma + sigma * sigma);
      result.share = {expected.value + belief * (measured - expected.value),
                      expected.sigma * std::sqrt(1.0 - belief)};
    }
    OfKinds off_skin{}, off_white{};
    for (int i = 0; i < kMostKinds; ++i) {
      off_skin[i] = result.share.value * means.skin[i];
      off_white[i] = result.share.value * means.spectralon[i];
    }
    result.card_ratio = card.RatioWithout(off_skin, off_white);
  }
  return result;
}

void RemoveStrayLight(double share, const FrameMeans& means, Mosaic& mosaic) {
  for (int y = 0; y < mosaic.height(); ++y) {
    for (int x = 0; x < mosaic.width(); ++x) {
      const int i = KindOf(mosaic.x0 + x, mosaic.y0 + y, mosaic.period);
      mosaic.skin(x, y) -= static_cast<float>(share * means.skin[i]);
      mosaic.spectralon(x, y) -= static_cast<float>(share * means.spectralon[i]);
    }
  }
}

}  // namespace dermap
