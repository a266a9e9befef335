// SPDX-License-Identifier: Apache-2.0
// Interpolation on a regular grid of three axes.
#include "fit/spectra/grid3.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace dermap {

Grid3::Grid3(const std::array<GridAxis, 3>& axes, std::vector<double> values, int stencil)
    : axes_(axes), values_(std::move(values)), stencil_(stencil) {
  assert(stencil >= 2 && stencil <= kMaxStencil);
  assert(values_.size() == static_cast<std::size_t>(axes[0].count) * axes[1].count * axes[2].count);
}

Grid3::Weights Grid3::WeightsAt(int axis, double x) const noexcept {
  const GridAxis& a = axes_[axis];
  const bool beyond = x < a.first || x > a.last;
  const double u = (std::clamp(x, a.first, a.last) - a.first) / a.Step();
  Weights w{};
  w.count = std::min(stencil_, a.count);
  w.first = std::clamp(static_cast<int>(std::floor(u)) - w.count / 2 + 1, 0, a.count - w.count);
  const double at = u - w.first;
  for (int i = 0; i < w.count; ++i) {
    double value = 1.0, slope = 0.0;
    for (int j = 0; j < w.count; ++j) {
      if (j == i) continue;
      slope = (slope * (at - j) + value) / (i - j);
      value *= (at - j) / (i - j);
    }
    w.value[i] = value;
    w.slope[i] = beyond ? 0.0 : slope / a.Step();
  }
  return w;
}

Grid3::Sample Grid3::At(const std::array<double, 3>& x) const noexcept {
  const Weights a = WeightsAt(0, x[0]), b = WeightsAt(1, x[1]), c = WeightsAt(2, x[2]);
  Sample sample{0.0, {0.0, 0.0, 0.0}};
  for (int i = 0; i < a.count; ++i) {
    double row = 0.0, row_b = 0.0, row_c = 0.0;
    for (int j = 0; j < b.count; ++j) {
      const double* line =
          &values_[(static_cast<std::size_t>(a.first + i) * axes_[1].count + b.first + j) * axes_[2].count +
                   c.first];
      double sum = 0.0, sum_c = 0.0;
      for (int k = 0; k < c.count; ++k) {
        sum += c.value[k] * line[k];
        sum_c += c.slope[k] * line[k];
      }
      row += b.value[j] * sum;
      row_b += b.slope[j] * sum;
      row_c += b.value[j] * sum_c;
    }
    sample.value += a.value[i] * row;
    sample.slope[0] += a.slope[i] * row;
    sample.slope[1] += a.value[i] * row_b;
    sample.slope[2] += a.value[i] * row_c;
  }
  return sample;
}

}  // namespace dermap
