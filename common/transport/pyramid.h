// SPDX-License-Identifier: Apache-2.0
// The same sum of Gaussians as the cascade, wide ones at reduced resolution. Fast because a Gaussian that is
// many pixels wide needs few samples: sizes halve with every second Gaussian, so nearly all time goes to the
// few narrow ones.
//
// A level's images are coefficients of cubic B-splines. The spline's own blur, and that of the pair averages
// which lead from level to level, are divided out of the transfer function of the level's first kernel, so
// they cost nothing. What is left is aliasing: about 1e-4 rms of the image, at most 1e-3 beside a sharp edge
// (tested against the cascade).
#pragma once

#include <array>
#include <map>
#include <tuple>
#include <vector>

#include "common/transport/convolver.h"

namespace dermap {

class PyramidConvolver : public Convolver {
 public:
  PyramidConvolver(const Domain& domain, double pixel_size_mm, Border border);
  void Convolve(const PlaneF& input, std::span<const ConvolutionTarget> targets) override;
  void ConvolveTransposed(const PlaneF& result, const ResponseWeights& weights, PlaneF& input) override;

 private:
  // Cubic B-spline weights that take a level (pixels of 2^level) to full resolution, along x and along y.
  struct Upsampler {
    int scale = 1;
    std::array<std::vector<float>, 4> along_x;  // for each x
    std::vector<std::array<float, 4>> along_y;  // for each phase y mod scale
  };

  const SymmetricKernel& Kernel(int from_level, int from, int to_level, int to);
  int LevelAfter(int level, int last) const;
  void Descend(int from_level, int to_level);
  void Accumulate(const PlaneF& level_plane, int level, int gaussian,
                  std::span<const ConvolutionTarget> targets);
  const float* UpsampledRow(const PlaneF& level_plane, const Upsampler& upsampler, int y);
  int LevelRow(int row, int height) const;
  // The transposes of Descend, Accumulate and UpsampledRow.
  void Ascend(int from_level, int to_level);
  void AddWeighted(const PlaneF& result, const ResponseWeights& weights, int gaussian, int level);
  void AddCoarsened(int level);

  Domain domain_;
  double pixel_size_mm_;
  Border border_;
  std::vector<PlaneF> planes_;         // one a level
  std::vector<SeparableBlur> blurs_;   // one a level
  std::vector<Upsampler> upsamplers_;  // [0] is unused
  PlaneF rows_coarsened_;
  std::vector<float> spline_row_, expanded_row_, full_row_, zero_row_;
  std::map<std::tuple<int, int, int, int>, SymmetricKernel> kernels_;
};

}  // namespace dermap
