// SPDX-License-Identifier: Apache-2.0
// The few unknowns of one pixel: normal equations and a damped step within bounds.
#pragma once

#include <array>

#include "fit/parameter_space.h"

namespace dermap {

// Least squares of one pixel in scaled parameters: minimise |J step - r|^2, both divided by the noise.
struct PixelSystem {
  int count = 0;
  std::array<FreeVector, kUnknownCount> normal{};  // J^T J
  FreeVector rhs{};                                // J^T r

  // One equation: derivatives by the free parameters and the residual (measured - predicted), in units of the
  // noise.
  void Add(const FreeVector& derivatives, double residual) noexcept;
  // Pulls parameter j, now at `position`, towards `center` with 1 / variance `precision`.
  void AddPrior(int j, double precision, double center, double position) noexcept;
  double Trace() const noexcept;
};

// Minimises |J step - r|^2 + damping |step|^2 such that position + step stays within the bounds: goes towards
// the minimum until the first parameter meets its bound, holds that one and goes on with the others (at most
// `count` legs). Each leg goes down, so the step never makes the least squares worse.
FreeVector BoundedStep(const PixelSystem& system, double damping, const FreeVector& position,
                       const FreeVector& lower, const FreeVector& upper);

// Diagonal of (J^T J + ridge I)^-1: the variances.
FreeVector InverseDiagonal(const PixelSystem& system, double ridge);

}  // namespace dermap
