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

class PathGrid {
 public:
  // At least `margin_mm` of skin around the patch; where `lossy`, a rim beyond it that takes what arrives.
  PathGrid(int patch_width, int patch_height, double pixel_size_mm, double margin_mm, bool lossy);

  const Domain& domain() const { return domain_; }
  double pixel_size_mm() const { return pixel_size_mm_; }
  // The grid whose pixels are `factor` (1, 2 or 4) times as large.
  int Width(int factor) const { return domain_.width / factor; }
  int Height(int factor) const { return domain_.height / factor; }
  double Nyquist_per_mm(int factor) const;

  // Share of each pixel of the coarser grid that is skin (1, or 0 in the rim), and that lies in the patch.
  PlaneF SkinShare(int factor) const;
  PlaneF PatchShare(int factor) const;

  // spectrum *= transform(k), on a spectrum of any of the grids.
  void Multiply(const RadialTransform& transform, PlaneF& spectrum) const;

 private:
  Domain domain_;
  Region skin_;
  double pixel_size_mm_;
  Plane<int> index_;  // of each (u, v), into RadialTransform's samples
  PlaneF fraction_;

  PlaneF Share(const Region& region, int factor) const;
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

}  // namespace dermap
