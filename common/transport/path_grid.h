// SPDX-License-Identifier: Apache-2.0
// The grid of the path engine: the patch with skin around it, its cosine transform, and a coarser grid that
// shares the low frequencies.
//
// The cosine transform (DCT-II) diagonalises every convolution with a symmetric kernel whose plane goes on
// mirrored at the border; samples of the coarse grid lie in the middle of their factor x factor pixels, so a
// coarse spectrum is the corner of the fine one.
#pragma once

#include <span>
#include <vector>

#include "common/core/image.h"
#include "common/transport/domain.h"

namespace dermap {

// A kernel's transform over lateral frequency, sampled finely enough for linear interpolation.
class RadialTransform {
 public:
  RadialTransform() = default;
  // Values at TableFrequencies_per_mm(); beyond the last they fall as 1 / k.
  explicit RadialTransform(std::span<const float> values);
  double At(double k_per_mm) const noexcept;
  const float* samples() const noexcept { return samples_.data(); }

 private:
  std::vector<float> samples_;
};

// Which pixels take part. In fine pixels the sides of both are multiples of 8 and the position of `near` in
// `whole` is one of 4, so that grids up to 4 times coarser share borders with them and have even sides.
struct PathLayout {
  Domain near;   // the patch, and around it what one passage of the epidermis carries light from
  Domain whole;  // near (as its `patch`), and around it the skin that light comes back from below
  Region skin;   // of whole: beyond it what arrives is lost
};
// A little more than `margin_mm` around the patch; where `lossy`, its outer part only takes what arrives.
PathLayout MakePathLayout(int patch_width, int patch_height, double pixel_size_mm, double margin_mm,
                          bool lossy);

// The same in pixels that are `factor` times as large.
Domain Coarsened(const Domain& domain, int factor);

// The frequencies of a rectangle's cosine transform.
class PathGrid {
 public:
  PathGrid(int width, int height, double pixel_size_mm);
  // spectrum *= transform(k), for a spectrum of this rectangle, or of a coarser grid on it.
  void Multiply(const RadialTransform& transform, PlaneF& spectrum) const;

 private:
  Plane<int> index_;  // of each (u, v), into RadialTransform's samples
  PlaneF fraction_;
};

// In place; width and height even.
void CosineTransform(PlaneF& plane);
void InverseCosineTransform(PlaneF& plane);

// The corner of a spectrum, for the grid coarser by `factor`, scaled so that values stay values; and back,
// with nothing at the frequencies between.
void TruncateSpectrum(const PlaneF& fine, int factor, PlaneF& coarse);
void ExtendSpectrum(const PlaneF& coarse, int factor, PlaneF& fine);
// Means of factor x factor pixels.
void AverageBlocks(const PlaneF& fine, int factor, PlaneF& coarse);
// Share of each pixel that lies in a region of a plane of fine pixels.
PlaneF ShareOf(const Region& region, int width, int height, int factor);
// The part of `whole` that its domain calls patch.
void Crop(const PlaneF& whole, const Domain& domain, PlaneF& part);

}  // namespace dermap
