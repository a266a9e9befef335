// SPDX-License-Identifier: Apache-2.0
// The few unknowns of one pixel: normal equations and a damped step within bounds.
#pragma once

#include <array>

#include "fit/parameter_space.h"

namespace dermap {

// Least squares of one pixel in scaled parameters: minimise |J step - r|^2, both divided by the noise.
struct PixelSystem {
  int count = 0;
  std::array<FreeVector, kParameterCount> normal{};  // J^T J
  FreeVector rhs{};                                  // J^T r

  // One equation: derivatives by the free parameters and the residual (measured - predicted), in units of the
  // noise.
  void Add(const FreeVector& derivatives, double residual) noexcept;
  // Pulls parameter j, now at `position`, towards `center` with 1 / variance `precision`.
  void AddPrior(int j, double precision, double center, double position) noexcept;
  double Trace() const noexcept;
};

// Solves (J^T J + damping I) step = J^T r such that position + step stays within the bounds: what would leave
// is set on its bound and the others are solved again (an active set that only grows, at most `count`
// rounds).
FreeVector BoundedStep(const PixelSystem& system, double damping, const FreeVector& position,
                       const FreeVector& lower, const FreeVector& upper);

// Diagonal of (J^T J + ridge I)^-1: the variances.
FreeVector InverseDiagonal(const PixelSystem& system, double ridge);

}  // namespace dermap
