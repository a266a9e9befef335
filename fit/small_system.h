// SPDX-License-Identifier: Apache-2.0
// Least squares of a handful of unknowns within bounds, made for being solved for every pixel.
#pragma once

#include "fit/pixel_step.h"

namespace dermap {

// Minimises sum of weight (row . x - residual)^2 + sum of precision (x - center)^2.
class SmallSystem {
 public:
  explicit SmallSystem(int count) : count_(count) {}

  void Add(const double* row, double residual, double weight) noexcept {
    for (int i = 0; i < count_; ++i) {
      const double scaled = weight * row[i];
      rhs_[i] += scaled * residual;
      for (int j = 0; j <= i; ++j) matrix_[i][j] += scaled * row[j];
    }
  }
  void AddPrior(int j, double precision, double center) noexcept {
    matrix_[j][j] += precision;
    rhs_[j] += precision * center;
  }

  // x within [lower, upper], which must hold 0, and the variances: the diagonal of the matrix's inverse,
  // bounds not counted. Needs a positive precision for every unknown.
  void Solve(const FreeVector& lower, const FreeVector& upper, FreeVector& x, FreeVector& variance) const;

 private:
  int count_;
  double matrix_[kUnknownCount][kUnknownCount] = {};  // lower triangle
  double rhs_[kUnknownCount] = {};
};

}  // namespace dermap
