// SPDX-License-Identifier: Apache-2.0
// Ratios of sums over the gray card: with shot noise these are the best estimate of the ratio of two flashes.
#include "calibrate/gray_card.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "calibrate/statistics.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr int kSmallestSide = 16;
constexpr int kBlocks = 4;             // a side
constexpr double kFaintColour = 0.05;  // of the strongest: weaker ones say nothing of the filter

struct Sums {
  double a = 0.0;
  double b = 0.0;
  int count = 0;
  void Add(const Sums& o) {
    a += o.a;
    b += o.b;
    count += o.count;
  }
};

int Even(double value) {
  return 2 * static_cast<int>(std::lround(value / 2.0));
}

}  // namespace

PixelRegion GrayCardRegion(const RigConfig& rig, int frame_width, int frame_height) {
  const auto& share = rig.gray_card_region;
  const PixelRegion region{Even(share[0] * frame_width), Even(share[1] * frame_height),
                           Even(share[2] * frame_width), Even(share[3] * frame_height)};
  if (region.x < 0 || region.y < 0 || region.x + region.width > frame_width ||
      region.y + region.height > frame_height || std::min(region.width, region.height) < kSmallestSide) {
    throw InputError("gray_card_region of rig '" + rig.name + "' is [" + Short(share[0]) + ", " +
                     Short(share[1]) + ", " + Short(share[2]) + ", " + Short(share[3]) +
                     "]; expected x, y, width, height as shares of the frame (" +
                     std::to_string(frame_width) + "x" + std::to_string(frame_height) +
                     "), within it and at least " + std::to_string(kSmallestSide) +
                     " photosites wide and high: correct it in the rig's file");
  }
  return region;
}

double GrayCardSignal(const SignalFrame& frame, const PixelRegion& card) {
  std::array<Sums, kLatticeCount> sums;
  for (int y = card.y; y < card.y + card.height; ++y) {
    for (int x = card.x; x < card.x + card.width; ++x) {
      if ((frame.mask(x, y) & kPhotositeHot) != 0) continue;  // saturated ones are bright: they count here
      sums[LatticeOf(x, y)].Add({frame.signal(x, y), 0.0, 1});
    }
  }
  double strongest = 0.0;
  for (const Sums& s : sums) strongest = std::max(strongest, s.count > 0 ? s.a / s.count : 0.0);
  return strongest;
}

GrayCardRatio CompareGrayCard(const SignalFrame& a, const SignalFrame& b, const PixelRegion& card) {
  std::array<Sums, kMostKinds> kinds;
  std::array<Sums, kBlocks * kBlocks> blocks;
  for (int y = card.y; y < card.y + card.height; ++y) {
    Sums* block_row = &blocks[(y - card.y) * kBlocks / card.height * kBlocks];
    for (int block = 0; block < kBlocks; ++block) {
      const auto begin = [&](int k) { return card.x + (k * card.width + kBlocks - 1) / kBlocks; };
      for (int x = begin(block); x < begin(block + 1); ++x) {
        if (a.mask(x, y) != 0 || b.mask(x, y) != 0) continue;
        const Sums one{a.signal(x, y), b.signal(x, y), 1};
        kinds[KindOf(x, y, a.period)].Add(one);
        block_row[block].Add(one);
      }
    }
  }
  GrayCardRatio result;
  Sums all;
  for (int i = 0; i < kMostKinds; ++i) {
    all.Add(kinds[i]);
    if (kinds[i].count == 0) continue;
    result.mean_a[i] = kinds[i].a / kinds[i].count;
    result.mean_b[i] = kinds[i].b / kinds[i].count;
    result.count[i] = kinds[i].count;
  }
  result.ratio = all.b > 0.0 ? all.a / all.b : std::nan("");
  const double strongest = *std::max_element(result.mean_b.begin(), result.mean_b.end());
  for (int i = 0; i < kMostKinds; ++i) {
    if (result.count[i] == 0.0 || result.mean_b[i] < kFaintColour * strongest) continue;
    result.colour_difference = std::max(result.colour_difference,
                                        std::abs(result.mean_a[i] / result.mean_b[i] / result.ratio - 1.0));
  }
  for (const Sums& block : blocks) {
    if (block.count == 0 || !(block.b > 0.0)) continue;
    result.unevenness = std::max(result.unevenness, std::abs(block.a / block.b / result.ratio - 1.0));
  }
  return result;
}

double GrayCardRatio::RatioWithout(const OfKinds& a, const OfKinds& b) const {
  double above = 0.0;
  double below = 0.0;
  for (int i = 0; i < kMostKinds; ++i) {
    above += count[i] * (mean_a[i] - a[i]);
    below += count[i] * (mean_b[i] - b[i]);
  }
  return above / below;
}

}  // namespace dermap
