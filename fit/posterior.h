// SPDX-License-Identifier: Apache-2.0
// The objective of the fits, exactly: half the squared misfit in logarithms over the noise, and half the
// squared details over their prior variances. The fast fit approaches its minimum; the reference finds it.
#pragma once

#include <vector>

#include "fit/detail_model.h"
#include "fit/octaves.h"
#include "fit/patch_problem.h"

namespace dermap {

class Posterior {
 public:
  // Borrows all; detail.prior[0] and detail.scatter[0] belong to the problem's own pixels.
  Posterior(const PatchProblem& problem, const DetailView& detail, const SkinPoint& fixed);

  // The free parameters in scaled units, one plane each.
  using Position = std::vector<PlaneF>;
  Position PositionOf(const ParameterMaps& maps) const;
  // Values beyond a bound count as the bound.
  ParameterMaps MapsOf(const Position& position) const;

  double Value(const Position& position) const;  // costs a render
  // And the gradient: a product with the transposed Jacobian. The data do not pull at what lies beyond a
  // bound.
  double ValueAndGradient(const Position& position, Position& gradient) const;

  double PriorValue(const Position& position) const;
  double PriorValueAndGradient(const Position& position, Position& gradient) const;

  const std::vector<GridShape>& shapes() const { return shapes_; }
  const PatchProblem& problem() const { return problem_; }

 private:
  double AddPrior(const PlaneF& plane, int j, std::size_t octave, PlaneF* gradient) const;

  const PatchProblem& problem_;
  DetailView detail_;
  SkinPoint fixed_;
  std::vector<GridShape> shapes_;
};

}  // namespace dermap
