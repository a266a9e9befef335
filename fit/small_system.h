// SPDX-License-Identifier: Apache-2.0
// Least squares of a handful of unknowns within bounds, made for being solved in every pixel.
#pragma once

#include <algorithm>
#include <cmath>

#include "fit/pixel_step.h"

namespace dermap {

// Minimises sum of weight (row . x - residual)^2 + sum of precision (x - center)^2 over N unknowns.
template <int N>
class SmallSystem {
 public:
  void Add(const float* row, double residual, double weight) noexcept {
    for (int i = 0; i < N; ++i) {
      const double scaled = weight * row[i];
      rhs_[i] += scaled * residual;
      for (int j = 0; j <= i; ++j) matrix_[i][j] += scaled * row[j];
    }
  }
  void AddPrior(int j, double precision, double center) noexcept {
    matrix_[j][j] += precision;
    rhs_[j] += precision * center;
  }
  // Adds factor (x - center)' precision (x - center).
  void AddPrior(const FreeMatrix& precision, double factor, const FreeVector& center) noexcept {
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j) {
        if (j <= i) matrix_[i][j] += factor * precision[i][j];
        rhs_[i] += factor * precision[i][j] * center[j];
      }
  }
  // Trace of the matrix's inverse times `other`, which is symmetric.
  double InverseTimes(const FreeMatrix& other) const {
    double inverse[N][N] = {}, trace = 0.0;
    Factor(inverse);
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j)
        for (int k = std::max(i, j); k < N; ++k) trace += inverse[k][i] * inverse[k][j] * other[i][j];
    return trace;
  }
  double matrix(int i, int j) const noexcept { return i >= j ? matrix_[i][j] : matrix_[j][i]; }
  double rhs(int i) const noexcept { return rhs_[i]; }

  // x within [lower, upper], which must hold 0, and the variances: the diagonal of the matrix's inverse,
  // bounds not counted. Every unknown needs a positive precision. Cholesky factors.
  void Solve(const FreeVector& lower, const FreeVector& upper, FreeVector& x, FreeVector& variance) const {
    double inverse[N][N] = {};  // of the factor L, lower triangle
    Factor(inverse);
    double half[N];  // L^-1 rhs
    for (int i = 0; i < N; ++i) {
      half[i] = 0.0;
      for (int j = 0; j <= i; ++j) half[i] += inverse[i][j] * rhs_[j];
    }
    bool within = true;
    for (int j = 0; j < N; ++j) {
      x[j] = variance[j] = 0.0;
      for (int i = j; i < N; ++i) {
        x[j] += inverse[i][j] * half[i];
        variance[j] += inverse[i][j] * inverse[i][j];
      }
      within = within && x[j] >= lower[j] && x[j] <= upper[j];
    }
    if (!within) x = BoundedStep(AsPixelSystem(), 0.0, FreeVector{}, lower, upper);
  }

 private:
  void Factor(double (&inverse)[N][N]) const {
    double factor[N][N];
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = matrix_[i][j];
        for (int k = 0; k < j; ++k) sum -= factor[i][k] * factor[j][k];
        factor[i][j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum * inverse[j][j];
        if (i == j) inverse[i][i] = 1.0 / factor[i][i];
      }
      for (int j = 0; j < i; ++j) {
        double sum = 0.0;
        for (int k = j; k < i; ++k) sum += factor[i][k] * inverse[k][j];
        inverse[i][j] = -sum * inverse[i][i];
      }
    }
  }
  PixelSystem AsPixelSystem() const {
    PixelSystem system;
    system.count = N;
    for (int i = 0; i < N; ++i) {
      system.rhs[i] = rhs_[i];
      for (int j = 0; j < N; ++j) system.normal[i][j] = matrix(i, j);
    }
    return system;
  }

  double matrix_[N][N] = {};  // lower triangle
  double rhs_[N] = {};
};

}  // namespace dermap
