// SPDX-License-Identifier: Apache-2.0
// Normal equations of one pixel, solved by Cholesky factors of at most 5 x 5.
#include "fit/pixel_step.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace dermap {
namespace {

using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kUnknownCount, kUnknownCount>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kUnknownCount, 1>;

// Solves for the parameters in `open` (indices), the others having moved by `step`.
void SolveOpen(const PixelSystem& system, double damping, const std::array<int, kUnknownCount>& open,
               int open_count, FreeVector& step) {
  SmallMatrix matrix(open_count, open_count);
  SmallVector rhs(open_count);
  for (int a = 0; a < open_count; ++a) {
    const int i = open[a];
    rhs[a] = system.rhs[i];
    for (int j = 0; j < system.count; ++j) rhs[a] -= system.normal[i][j] * step[j];
    for (int b = 0; b < open_count; ++b) {
      matrix(a, b) = system.normal[i][open[b]];
      rhs[a] += matrix(a, b) * step[open[b]];
    }
    matrix(a, a) += damping;
  }
  const SmallVector solution = matrix.ldlt().solve(rhs);
  for (int a = 0; a < open_count; ++a) step[open[a]] = solution[a];
}

}  // namespace

void PixelSystem::Add(const FreeVector& derivatives, double residual) noexcept {
  for (int i = 0; i < count; ++i) {
    rhs[i] += derivatives[i] * residual;
    for (int j = 0; j < count; ++j) normal[i][j] += derivatives[i] * derivatives[j];
  }
}

void PixelSystem::AddPrior(int j, double precision, double center, double position) noexcept {
  normal[j][j] += precision;
  rhs[j] += precision * (center - position);
}

double PixelSystem::Trace() const noexcept {
  double trace = 0.0;
  for (int i = 0; i < count; ++i) trace += normal[i][i];
  return trace;
}

FreeVector BoundedStep(const PixelSystem& system, double damping, const FreeVector& position,
                       const FreeVector& lower, const FreeVector& upper) {
  FreeVector step{};
  std::array<int, kUnknownCount> open{};
  int open_count = system.count;
  for (int i = 0; i < open_count; ++i) open[i] = i;
  while (open_count > 0) {
    FreeVector target = step;
    SolveOpen(system, damping, open, open_count, target);
    double share = 1.0;  // of the way to the target, until the first bound
    int blocked = -1;
    for (int a = 0; a < open_count; ++a) {
      const int i = open[a];
      const double way = target[i] - step[i];
      const double room = (way < 0.0 ? lower[i] : upper[i]) - position[i] - step[i];
      if (way == 0.0 || room / way >= share) continue;
      share = std::max(room / way, 0.0);
      blocked = a;
    }
    for (int a = 0; a < open_count; ++a) step[open[a]] += share * (target[open[a]] - step[open[a]]);
    if (blocked < 0) break;
    open[blocked] = open[--open_count];
  }
  return step;
}

FreeVector InverseDiagonal(const PixelSystem& system, double ridge) {
  SmallMatrix matrix(system.count, system.count);
  for (int i = 0; i < system.count; ++i)
    for (int j = 0; j < system.count; ++j) matrix(i, j) = system.normal[i][j] + (i == j ? ridge : 0.0);
  const SmallMatrix inverse = matrix.ldlt().solve(SmallMatrix::Identity(system.count, system.count));
  FreeVector diagonal{};
  for (int i = 0; i < system.count; ++i) diagonal[i] = inverse(i, i);
  return diagonal;
}

}  // namespace dermap
