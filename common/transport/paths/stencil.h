// SPDX-License-Identifier: Apache-2.0
// Convolution with a small kernel that is even along both axes.
#pragma once

#include <functional>
#include <vector>

#include "common/core/image.h"
#include "common/transport/blur.h"

namespace dermap {

class Stencil {
 public:
  Stencil() = default;
  // The kernel whose transform at (kx, ky), radians per pixel, is `transfer`, cut to the disc of `radius`
  // pixels; what is cut is given back to the middle, so that the sum of the taps is the transfer at 0.
  Stencil(const std::function<double(double kx, double ky)>& transfer, int radius);

  int radius() const { return static_cast<int>(rows_.size()) - 1; }
  bool empty() const { return rows_.empty(); }
  // taps of rows +dy and -dy: [dy][dx], dx = 0 ... reach of the row
  const std::vector<std::vector<float>>& rows() const { return rows_; }

 private:
  std::vector<std::vector<float>> rows_;
};

// Keeps its scratch between calls; one a thread.
class StencilRunner {
 public:
  explicit StencilRunner(Border border) : border_(border) {}
  // sum += factor * (stencil * in), where factor is a plane of the same shape (null: 1).
  void AddTo(const PlaneF& in, const Stencil& stencil, const PlaneF* factor, PlaneF& sum);

 private:
  void FoldRows(const PlaneF& in, int y, int radius);
  Border border_;
  int stride_ = 0;
  std::vector<float> folded_;  // row dy: in[y - dy] + in[y + dy], with `radius` samples more on both sides
  std::vector<float> zero_row_;
};

}  // namespace dermap
