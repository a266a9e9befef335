// SPDX-License-Identifier: Apache-2.0
// Clipped values pile up, and have no noise.
#include "calibrate/saturation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace dermap {
namespace {

constexpr double kMostPhotosites = 4e5;  // of a frame that are counted, about
constexpr int kPile_dn = 12;             // width of a pile of clipped values: their noise
constexpr int kSlope_dn = 48;            // below it, where values are still spread
constexpr int kFewestClipped = 64;
constexpr double kSteep = 8.0;  // times as many a step as below
constexpr double kLit = 0.15;   // of the pile's level: photosites above it have noise that shows
constexpr int kAlike_dn = 6;
constexpr double kMostAlike =
    0.6;  // share of neighbours of one kind that are alike where light has its noise
constexpr double kClippedAlike = 0.8;

// Clipped photosites show no noise where those below do; an even target without any noise is not clipped.
bool HasNoNoise(const BayerFrame& frame, int pile) {
  double clipped = 0, clipped_alike = 0, lit = 0, lit_alike = 0;
  const auto& v = frame.values;
  for (int y = 0; y < v.height(); ++y) {
    for (int x = 0; x + frame.period < v.width(); ++x) {
      const int here = v(x, y), next = v(x + frame.period, y);
      const bool alike = std::abs(here - next) <= kAlike_dn;
      if (here >= pile) {
        clipped += 1, clipped_alike += alike ? 1 : 0;
      } else if (here > kLit * pile && next < pile) {
        lit += 1, lit_alike += alike ? 1 : 0;
      }
    }
  }
  return clipped_alike > kClippedAlike * clipped && lit_alike < kMostAlike * lit;
}

}  // namespace

double SaturationLevel(const BayerFrame& frame, double stated) {
  std::vector<std::uint32_t> histogram(65536, 0);
  const int rows = std::max(1, static_cast<int>(static_cast<double>(frame.values.size()) / kMostPhotosites));
  for (int y = 0; y < frame.values.height(); y += rows | 1) {  // odd: rows of all colours
    for (int x = 0; x < frame.values.width(); ++x) ++histogram[frame.values(x, y)];
  }
  int top = 65535;
  while (top > 0 && histogram[top] == 0) --top;
  if (top < kPile_dn + kSlope_dn || top >= stated) return stated;
  double pile = 0.0, below = 0.0;
  for (int v = top - kPile_dn + 1; v <= top; ++v) pile += histogram[v];
  for (int v = top - kPile_dn - kSlope_dn + 1; v <= top - kPile_dn; ++v) below += histogram[v];
  const bool piled = pile >= kFewestClipped && pile / kPile_dn > kSteep * below / kSlope_dn;
  const int first = top - kPile_dn + 1;
  return piled && HasNoNoise(frame, first) ? first : stated;
}

}  // namespace dermap
