// SPDX-License-Identifier: Apache-2.0
// One patch at one size: data, forward model and free parameters together, with the renders counted.
#pragma once

#include <vector>

#include "common/transport/forward_model.h"
#include "fit/masked_fill.h"
#include "fit/objective.h"
#include "fit/parameter_space.h"
#include "fit/pixel_step.h"
#include "fit/prepare.h"

namespace dermap {

// Maps, what they render to, and how far that is from the data.
struct FitState {
  ParameterMaps maps;
  std::vector<PlaneF> predicted;
  Misfit misfit;
};

// Derivatives of reflectance by the scaled free parameters, [free parameter][band].
using DerivativePlanes = std::vector<std::vector<PlaneF>>;

class PatchProblem {
 public:
  // Borrows data and model.
  PatchProblem(const FitData& data, const ForwardModel& model, ParameterSpace space);

  const FitData& data() const { return data_; }
  const ForwardModel& model() const { return model_; }
  const ParameterSpace& space() const { return space_; }

  SkinPoint PointAt(const ParameterMaps& maps, std::size_t pixel) const {
    return dermap::PointAt(maps, pixel, model_.tissue().junction_absorbance);
  }
  // Maps of one point everywhere, with a plane for the junction where it is free.
  ParameterMaps UniformMaps(const SkinPoint& point) const;

  // Fills masked pixels, renders the full patch and compares.
  FitState StateOf(ParameterMaps maps);

  // Forward differences [D08 6.3]: each free parameter is raised by `step` (scaled units) in all pixels at
  // once and the full patch rendered, so a derivative holds the cross-talk of the neighbours as well. It is
  // lowered instead where the upper bound is near.
  DerivativePlanes ForwardDifferences(const FitState& state, double step);

  // Full-patch renders so far; one forward difference counts as one.
  int renders() const { return renders_; }

 private:
  const FitData& data_;
  const ForwardModel& model_;
  ParameterSpace space_;
  MaskedFill fill_;
  int renders_ = 0;
};

// Derivatives of the logarithm of uniform skin's reflectance by its parameters.
SkinPoint SensitivityOf(const ForwardModel& model, int band, const SkinPoint& point);

// Normal equations of one pixel with the Jacobian of uniform skin, in logarithms. Seen so it needs no render
// of its own: d ln R / d p of the patch is close to that of uniform skin, whatever light the pixel gets.
// Where `predicted` is null the residual is against uniform skin too.
PixelSystem LocalSystem(const PatchProblem& problem, std::size_t pixel, const SkinPoint& p,
                        const std::vector<PlaneF>* predicted, double* chi2 = nullptr);

}  // namespace dermap
