// SPDX-License-Identifier: Apache-2.0
// A function of three numbers, sampled on a regular grid and interpolated with its derivatives.
#pragma once

#include <array>
#include <functional>
#include <vector>

namespace dermap {

struct GridAxis {
  double first = 0.0, last = 1.0;
  int count = 2;

  double Step() const { return (last - first) / (count - 1); }
  double At(int i) const { return first + i * Step(); }
};

// Tensor product of Lagrange's polynomials through the `stencil` nearest samples of each axis (fewer where
// the axis has fewer). Beyond an end of an axis the function goes on as it was at that end.
class Grid3 {
 public:
  Grid3() = default;
  // values[(i * count1 + j) * count2 + k]
  Grid3(const std::array<GridAxis, 3>& axes, std::vector<double> values, int stencil);

  struct Sample {
    double value;
    std::array<double, 3> slope;  // 0 along an axis whose end is passed
  };
  Sample At(const std::array<double, 3>& x) const noexcept;

 private:
  static constexpr int kMaxStencil = 6;
  struct Weights {
    int first, count;
    std::array<double, kMaxStencil> value, slope;
  };
  Weights WeightsAt(int axis, double x) const noexcept;

  std::array<GridAxis, 3> axes_{};
  std::vector<double> values_;
  int stencil_ = kMaxStencil;
};

}  // namespace dermap
