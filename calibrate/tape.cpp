// SPDX-License-Identifier: Apache-2.0
// Photosites sorted by where they lie in the window's own coordinates.
#include "calibrate/tape.h"

#include <algorithm>

namespace dermap {
namespace {

constexpr double kMostPhotosites = 2e5;  // of a mosaic that are looked at, about
constexpr double kMiddleFrom = 0.15;     // of the window's side
constexpr int kStretchesOfSide = kTapeStretches / 4;

// Calls use(place in the unit square, signals of one photosite).
template <class Use>
void ForEachPhotosite(const Mosaic& mosaic, const Window& window, const FrameMeans& means, const Use& use) {
  const Homography unit_from_camera = window.camera_from_unit.Inverse();
  // Steps that share no factor with any pattern, so that all kinds are met.
  const double share = double(mosaic.width()) * mosaic.height() / kMostPhotosites;
  int step = 1;
  while (step * step < share) step += step % 6 == 1 ? 4 : 2;
  for (int y = 0; y < mosaic.height(); y += step) {
    for (int x = 0; x < mosaic.width(); x += step) {
      if (mosaic.mask(x, y) != 0) continue;
      const Point p =
          unit_from_camera(mosaic.lens.IdealFromPhotosites({mosaic.x0 + x + 0.5, mosaic.y0 + y + 0.5}));
      const int i = KindOf(mosaic.x0 + x, mosaic.y0 + y, mosaic.period);
      use(p,
          RegionSignals{mosaic.skin(x, y), mosaic.spectralon(x, y), means.skin[i], means.spectralon[i], 1.0});
    }
  }
}

// The side that a point outside of the unit square lies beyond, and how far along it.
int StretchOf(Point p) {
  const std::array<double, 4> beyond{-p.y, p.x - 1.0, p.y - 1.0, -p.x};
  const auto side = static_cast<int>(std::max_element(beyond.begin(), beyond.end()) - beyond.begin());
  const double along = side % 2 == 0 ? p.x : p.y;
  return kStretchesOfSide * side +
         std::clamp(static_cast<int>(kStretchesOfSide * along), 0, kStretchesOfSide - 1);
}

}  // namespace

void RegionSignals::Add(const RegionSignals& o) {
  skin += o.skin;
  spectralon += o.spectralon;
  skin_mean += o.skin_mean;
  spectralon_mean += o.spectralon_mean;
  count += o.count;
}

TapeSignals SumTape(const Mosaic& mosaic, const Window& window, const FrameMeans& means, double from,
                    double to) {
  TapeSignals sums;
  ForEachPhotosite(mosaic, window, means, [&](Point p, const RegionSignals& one) {
    const double distance = std::max({-p.x, -p.y, p.x - 1.0, p.y - 1.0});
    if (distance >= from && distance <= to) sums[static_cast<std::size_t>(StretchOf(p))].Add(one);
  });
  return sums;
}

RegionSignals SumMiddle(const Mosaic& mosaic, const Window& window, const FrameMeans& means) {
  RegionSignals sum;
  ForEachPhotosite(mosaic, window, means, [&](Point p, const RegionSignals& one) {
    if (std::min({p.x, p.y, 1.0 - p.x, 1.0 - p.y}) >= kMiddleFrom) sum.Add(one);
  });
  return sum;
}

}  // namespace dermap
