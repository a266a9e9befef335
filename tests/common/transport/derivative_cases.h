// SPDX-License-Identifier: Apache-2.0
// Scenes and changes of them, for the tests of derivatives.
#pragma once

#include <span>
#include <vector>

#include "common/transport/forward_model.h"

namespace dermap {

struct DerivativeCase {
  int size;
  Illumination illumination;
  Tape tape;
  Coupling coupling;
  bool tattoo;
  BeneathTape beneath = BeneathTape::kEdge;
  Engine engine = Engine::kLowRank;
};

ForwardModel ModelOf(const DerivativeCase& c, std::span<const Band> bands, const char* source = "exact");
ParameterMaps SceneOf(const DerivativeCase& c);
// A change of every plane, a share of what parameters are.
ParameterMaps ChangeOf(const ParameterMaps& maps, std::uint32_t seed);
ParameterMaps Moved(const ParameterMaps& maps, const ParameterMaps& change, double step);
double Dot(const PlaneF& a, const PlaneF& b);

// |<J v, w> - <v, J' w>| over the sum of the bands' |J v| |w|, for random w.
double TransposeError(const ForwardModel& model, const ParameterMaps& maps, const ParameterMaps& change);

// How far the product with the Jacobian is from central differences of the render, Richardson's extrapolation
// of two steps: rms over the pixels, and of the mean, relative.
struct DifferenceError {
  double rms, mean;
};
std::vector<DifferenceError> ErrorsAgainstDifferences(const ForwardModel& model, const ParameterMaps& maps,
                                                      const ParameterMaps& change, double step);

}  // namespace dermap
