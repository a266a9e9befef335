// SPDX-License-Identifier: Apache-2.0
// Grid sizes, cosine transforms by OpenCV, and radial look-up.
#include "common/transport/path_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "common/core/kernel.h"
#include "common/optics/profile_table.h"

namespace dermap {
namespace {

constexpr int kGranule = 8;  // a grid four times coarser still has even sides
// On each side, where what arrives is lost. Mirrored light crosses it twice before it is back in the skin;
// what the mirror gives too much and the lost skin too little nearly cancel at this width (window_test.cpp).
constexpr double kRim_mm = 1.3;
constexpr double kRimBeyondMargin_mm = 0.35;
// How far around the patch one passage of the epidermis is followed; a caller who asks for more skin than the
// default gets more of this, too.
constexpr double kNear_mm = 1.0;
constexpr double kNearShare = 0.4;  // of the margin
constexpr int kRadialSamples = 1024;
constexpr double kTurn_per_mm = 0.1;  // samples are spaced like k below, like log k above
constexpr double kLastRadial_per_mm = 2000.0;

// The next multiple of the granule that has only factors 2, 3 and 5.
int TransformSize(int least) {
  for (int n = (least + kGranule - 1) / kGranule;; ++n) {
    int rest = n;
    for (const int factor : {2, 3, 5})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return n * kGranule;
  }
}

double Coordinate(double k_per_mm) {
  return std::asinh(k_per_mm / kTurn_per_mm);
}

// From a coordinate to a position among the samples.
double PositionScale() {
  static const double scale = (kRadialSamples - 1) / Coordinate(kLastRadial_per_mm);
  return scale;
}

cv::Mat View(PlaneF& plane) {
  return {plane.height(), plane.width(), CV_32F, plane.data()};
}

// Lagrange's cubic through the four nearest of (x, y) at `at`.
double Cubic(std::span<const double> x, std::span<const float> y, double at) {
  const auto count = static_cast<int>(x.size());
  const int above = static_cast<int>(std::upper_bound(x.begin(), x.end(), at) - x.begin());
  const int first = std::clamp(above - 2, 0, count - 4);
  double sum = 0.0;
  for (int i = first; i < first + 4; ++i) {
    double weight = 1.0;
    for (int j = first; j < first + 4; ++j)
      if (j != i) weight *= (at - x[j]) / (x[i] - x[j]);
    sum += weight * y[i];
  }
  return sum;
}

DERMAP_KERNEL
void MultiplyRow(const float* samples, const int* index, const float* fraction, int n,
                 float* __restrict values) noexcept {
  for (int x = 0; x < n; ++x) {
    const float here = samples[index[x]];
    values[x] *= here + fraction[x] * (samples[index[x] + 1] - here);
  }
}

}  // namespace

RadialTransform::RadialTransform(std::span<const float> values) {
  const auto k = TableFrequencies_per_mm();
  assert(values.size() == k.size());
  static const std::vector<double> coordinates = [&] {
    std::vector<double> list;
    for (const double frequency : k) list.push_back(Coordinate(frequency));
    return list;
  }();
  const double last = coordinates.back(), step = Coordinate(kLastRadial_per_mm) / (kRadialSamples - 1);
  samples_.resize(kRadialSamples + 1);
  for (int i = 0; i <= kRadialSamples; ++i) {
    const double at = i * step;
    const double value =
        at <= last ? Cubic(coordinates, values, at) : values.back() * std::sinh(last) / std::sinh(at);
    samples_[i] = static_cast<float>(value);
  }
}

double RadialTransform::At(double k_per_mm) const noexcept {
  const double position = std::min(Coordinate(k_per_mm) * PositionScale(), kRadialSamples - 1.0);
  const int index = static_cast<int>(position);
  return samples_[index] + (position - index) * (samples_[index + 1] - samples_[index]);
}

PathLayout MakePathLayout(int patch_width, int patch_height, double pixel_size_mm, double margin_mm,
                          bool lossy) {
  const auto pixels = [&](double length_mm) {
    return static_cast<int>(std::ceil(length_mm / pixel_size_mm));
  };
  const auto centred = [](int width, int height, int inner_width, int inner_height, int granule) {
    Domain domain;
    domain.width = width;
    domain.height = height;
    domain.patch = {(width - inner_width) / 2 / granule * granule,
                    (height - inner_height) / 2 / granule * granule, inner_width, inner_height};
    return domain;
  };
  PathLayout layout;
  const int around = pixels(std::min(margin_mm, std::max(kNear_mm, kNearShare * margin_mm)));
  const int near_width = TransformSize(patch_width + 2 * around);
  const int near_height = TransformSize(patch_height + 2 * around);
  layout.near = centred(near_width, near_height, patch_width, patch_height, 1);
  const int margin = pixels(margin_mm) + (lossy ? pixels(kRimBeyondMargin_mm) : 0);
  const int width = TransformSize(std::max(near_width, patch_width + 2 * margin));
  const int height = TransformSize(std::max(near_height, patch_height + 2 * margin));
  layout.whole =
      centred(width, height, near_width, near_height, kGranule / 2);  // in the middle: both are of granules
  const int rim_x = lossy ? std::min(pixels(kRim_mm), (width - patch_width) / 2) : 0;
  const int rim_y = lossy ? std::min(pixels(kRim_mm), (height - patch_height) / 2) : 0;
  layout.skin = {rim_x, rim_y, width - 2 * rim_x, height - 2 * rim_y};
  return layout;
}

Domain Coarsened(const Domain& domain, int factor) {
  Domain coarse;
  coarse.width = domain.width / factor;
  coarse.height = domain.height / factor;
  coarse.patch = {domain.patch.x / factor, domain.patch.y / factor, domain.patch.width / factor,
                  domain.patch.height / factor};
  return coarse;
}

PathGrid::PathGrid(int width, int height, double pixel_size_mm)
    : index_(width, height), fraction_(width, height) {
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double k = std::numbers::pi / pixel_size_mm *
                       std::hypot(static_cast<double>(u) / width, static_cast<double>(v) / height);
      const double position = std::min(Coordinate(k) * PositionScale(), kRadialSamples - 1.0);
      index_(u, v) = static_cast<int>(position);
      fraction_(u, v) = static_cast<float>(position - index_(u, v));
    }
  }
}

void PathGrid::Multiply(const RadialTransform& transform, PlaneF& spectrum) const {
  for (int v = 0; v < spectrum.height(); ++v)
    MultiplyRow(transform.samples(), index_.Row(v), fraction_.Row(v), spectrum.width(), spectrum.Row(v));
}

void CosineTransform(PlaneF& plane) {
  cv::Mat view = View(plane);
  cv::dct(view, view);
}

void InverseCosineTransform(PlaneF& plane) {
  cv::Mat view = View(plane);
  cv::idct(view, view);
}

void TruncateSpectrum(const PlaneF& fine, int factor, PlaneF& coarse) {
  EnsureShape(coarse, fine.width() / factor, fine.height() / factor);
  const float scale = 1.0f / static_cast<float>(factor);
  for (int v = 0; v < coarse.height(); ++v)
    std::transform(fine.Row(v), fine.Row(v) + coarse.width(), coarse.Row(v),
                   [scale](float value) { return value * scale; });
}

void ExtendSpectrum(const PlaneF& coarse, int factor, PlaneF& fine) {
  EnsureShape(fine, coarse.width() * factor, coarse.height() * factor);
  std::fill(fine.values().begin(), fine.values().end(), 0.0f);
  const auto scale = static_cast<float>(factor);
  for (int v = 0; v < coarse.height(); ++v)
    std::transform(coarse.Row(v), coarse.Row(v) + coarse.width(), fine.Row(v),
                   [scale](float value) { return value * scale; });
}

void AverageBlocks(const PlaneF& fine, int factor, PlaneF& coarse) {
  EnsureShape(coarse, fine.width() / factor, fine.height() / factor);
  const float share = 1.0f / static_cast<float>(factor * factor);
  for (int y = 0; y < coarse.height(); ++y) {
    float* out = coarse.Row(y);
    std::fill(out, out + coarse.width(), 0.0f);
    for (int row = 0; row < factor; ++row) {
      const float* in = fine.Row(y * factor + row);
      for (int x = 0; x < coarse.width(); ++x)
        for (int column = 0; column < factor; ++column) out[x] += share * in[x * factor + column];
    }
  }
}

PlaneF ShareOf(const Region& region, int width, int height, int factor) {
  PlaneF fine(width, height), coarse;
  for (int y = region.y; y < region.y + region.height; ++y)
    std::fill_n(fine.Row(y) + region.x, region.width, 1.0f);
  AverageBlocks(fine, factor, coarse);
  return coarse;
}

void Crop(const PlaneF& whole, const Domain& domain, PlaneF& part) {
  const Region& region = domain.patch;
  EnsureShape(part, region.width, region.height);
  for (int y = 0; y < region.height; ++y)
    std::copy_n(whole.Row(y + region.y) + region.x, region.width, part.Row(y));
}

}  // namespace dermap
