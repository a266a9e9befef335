// SPDX-License-Identifier: Apache-2.0
// Sampling of the four Bayer lattices.
#include "calibrate/mosaic.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/kernel.h"

namespace dermap {
namespace {

constexpr int kSmoothReach = 4;  // photosites, at least one step of the pattern
constexpr int kLongestPeriod = 6;
constexpr std::size_t kMostCells = 100'000;  // of a frame, of which the bright ones are told

template <class T>
Plane<T> CropPlane(const Plane<T>& plane, int x0, int y0, int x1, int y1) {
  Plane<T> out(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y) std::copy(plane.Row(y) + x0, plane.Row(y) + x1, out.Row(y - y0));
  return out;
}

DERMAP_KERNEL void AddTo(const float* from, std::size_t count, float* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += from[i];
}

// Sums along one axis in steps of the pattern, whole rows at a time.
void SmoothAlong(const PlaneF& in, PlaneF& out, int dx, int dy) {
  const int radius = std::max(1, kSmoothReach / std::max(dx, dy));
  for (int y = 0; y < in.height(); ++y) {
    float* to = out.Row(y);
    std::fill_n(to, in.width(), 0.0f);
    for (int k = -radius; k <= radius; ++k) {
      const int ny = y + k * dy;
      if (ny < 0 || ny >= in.height()) continue;
      const int shift = k * dx;
      const int first = std::max(0, -shift);
      const int last = std::min(in.width(), in.width() - shift);
      if (first < last) AddTo(in.Row(ny) + first + shift, static_cast<std::size_t>(last - first), to + first);
    }
  }
}

// `across` is room to work in.
void SmoothSum(PlaneF& plane, PlaneF& across, int period) {
  SmoothAlong(plane, across, period, 0);
  SmoothAlong(across, plane, 0, period);
}

DERMAP_KERNEL void Usable(const float* values, const float* weights, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = weights[i] > 0.0f ? values[i] : 0.0f;
}

DERMAP_KERNEL void DivideBy(const float* counts, std::size_t count, float* sums) {
  for (std::size_t i = 0; i < count; ++i) sums[i] = counts[i] > 0.0f ? sums[i] / counts[i] : 0.0f;
}

// Adds a row's usable photosites to cells of two.
DERMAP_KERNEL void AddPairs(const float* values, const std::uint8_t* mask, std::size_t cells, float* sums) {
  for (std::size_t i = 0; i < cells; ++i) {
    const float a = mask[2 * i] == 0 ? values[2 * i] : 0.0f;
    const float b = mask[2 * i + 1] == 0 ? values[2 * i + 1] : 0.0f;
    sums[i] += a + b;
  }
}

}  // namespace

Mosaic Crop(const Mosaic& mosaic, double left, double top, double right, double bottom) {
  // Whole patterns of any period begin at multiples of 6.
  const auto even = [](double v) {
    return kLongestPeriod * static_cast<int>(std::floor(v / kLongestPeriod));
  };
  const int x0 = std::clamp(even(left), 0, mosaic.width());
  const int y0 = std::clamp(even(top), 0, mosaic.height());
  const int x1 = std::clamp(even(right) + kLongestPeriod, x0, mosaic.width());
  const int y1 = std::clamp(even(bottom) + kLongestPeriod, y0, mosaic.height());
  Mosaic out;
  out.x0 = mosaic.x0 + x0;
  out.y0 = mosaic.y0 + y0;
  out.skin = CropPlane(mosaic.skin, x0, y0, x1, y1);
  out.spectralon = CropPlane(mosaic.spectralon, x0, y0, x1, y1);
  out.mask = CropPlane(mosaic.mask, x0, y0, x1, y1);
  out.skin_off = mosaic.skin_off;
  out.spectralon_off = mosaic.spectralon_off;
  out.scale = mosaic.scale;
  out.surface = mosaic.surface;
  out.lens = mosaic.lens;
  out.period = mosaic.period;
  return out;
}

double ReflectanceAt(const Mosaic& mosaic, double camera_x, double camera_y) {
  const Point p = mosaic.lens.PhotositesFromIdeal({camera_x, camera_y});
  double skin = 0.0;
  double spectralon = 0.0;
  for (int lattice = 0; lattice < kLatticeCount; ++lattice) {
    const LatticeCell c = CellAt(mosaic, lattice, p);
    if (!c.inside) continue;
    double own_skin = 0.0;
    double own_spectralon = 0.0;
    bool usable = true;
    for (int i = 0; i < 4; ++i) {
      const int x = c.x + 2 * (i & 1);
      const int y = c.y + 2 * (i >> 1);
      const double weight = ((i & 1) != 0 ? c.fx : 1 - c.fx) * ((i >> 1) != 0 ? c.fy : 1 - c.fy);
      usable = usable && mosaic.mask(x, y) == 0;
      own_skin += weight * mosaic.skin(x, y);
      own_spectralon += weight * mosaic.spectralon(x, y);
    }
    if (!usable) continue;
    skin += own_skin;
    spectralon += own_spectralon;
  }
  return spectralon > 0.0 ? mosaic.scale * skin / spectralon : std::numeric_limits<double>::quiet_NaN();
}

PlaneF CellReflectance(const Mosaic& mosaic, double darkest) {
  PlaneF skin(mosaic.width() / 2, mosaic.height() / 2);
  PlaneF spectralon(skin.width(), skin.height());
  const auto cells = static_cast<std::size_t>(skin.width());
  for (int y = 0; y < 2 * skin.height(); ++y) {
    AddPairs(mosaic.skin.Row(y), mosaic.mask.Row(y), cells, skin.Row(y / 2));
    AddPairs(mosaic.spectralon.Row(y), mosaic.mask.Row(y), cells, spectralon.Row(y / 2));
  }
  std::vector<float> sorted;
  const std::size_t step = spectralon.size() / kMostCells + 1;
  for (std::size_t i = 0; i < spectralon.size(); i += step) sorted.push_back(spectralon.data()[i]);
  const auto bright = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 95 / 100);
  if (sorted.empty()) return skin;
  std::nth_element(sorted.begin(), bright, sorted.end());
  const double limit = std::max(0.0, darkest * static_cast<double>(*bright));
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const float white = spectralon.data()[i];
    skin.data()[i] = white > limit ? static_cast<float>(mosaic.scale) * skin.data()[i] / white : 0.0f;
  }
  return skin;
}

SmoothSignals LatticeSmooth(const Mosaic& mosaic) {
  const int width = mosaic.width(), height = mosaic.height();
  const std::size_t size = mosaic.mask.size();
  PlaneF weights(width, height), across(width, height);
  SmoothSignals out{PlaneF(width, height), PlaneF(width, height)};
  for (std::size_t i = 0; i < size; ++i) weights.data()[i] = mosaic.mask.data()[i] == 0 ? 1.0f : 0.0f;
  Usable(mosaic.skin.data(), weights.data(), size, out.skin.data());
  Usable(mosaic.spectralon.data(), weights.data(), size, out.spectralon.data());
  SmoothSum(weights, across, mosaic.period);
  for (PlaneF* plane : {&out.skin, &out.spectralon}) {
    SmoothSum(*plane, across, mosaic.period);
    DivideBy(weights.data(), size, plane->data());
  }
  return out;
}

}  // namespace dermap
