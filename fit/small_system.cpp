// SPDX-License-Identifier: Apache-2.0
// Cholesky factors of a small matrix; the bounded step where a bound is met.
#include "fit/small_system.h"

#include <cmath>

namespace dermap {

void SmallSystem::Solve(const FreeVector& lower, const FreeVector& upper, FreeVector& x,
                        FreeVector& variance) const {
  double inverse[kUnknownCount][kUnknownCount] = {};  // of the factor L, lower triangle
  double factor[kUnknownCount][kUnknownCount];
  for (int i = 0; i < count_; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = matrix_[i][j];
      for (int k = 0; k < j; ++k) sum -= factor[i][k] * factor[j][k];
      factor[i][j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / factor[j][j];
    }
    inverse[i][i] = 1.0 / factor[i][i];
    for (int j = 0; j < i; ++j) {
      double sum = 0.0;
      for (int k = j; k < i; ++k) sum += factor[i][k] * inverse[k][j];
      inverse[i][j] = -sum * inverse[i][i];
    }
  }
  double half[kUnknownCount];  // L^-1 rhs
  for (int i = 0; i < count_; ++i) {
    half[i] = 0.0;
    for (int j = 0; j <= i; ++j) half[i] += inverse[i][j] * rhs_[j];
  }
  bool within = true;
  for (int j = 0; j < count_; ++j) {
    x[j] = variance[j] = 0.0;
    for (int i = j; i < count_; ++i) {
      x[j] += inverse[i][j] * half[i];
      variance[j] += inverse[i][j] * inverse[i][j];
    }
    within = within && x[j] >= lower[j] && x[j] <= upper[j];
  }
  if (within) return;
  PixelSystem system;
  system.count = count_;
  for (int i = 0; i < count_; ++i) {
    system.rhs[i] = rhs_[i];
    for (int j = 0; j <= i; ++j) system.normal[i][j] = system.normal[j][i] = matrix_[i][j];
  }
  x = BoundedStep(system, 0.0, FreeVector{}, lower, upper);
}

}  // namespace dermap
