// SPDX-License-Identifier: Apache-2.0
// What the data say of the details of every octave, and the evidence of any set of unknowns, without another
// fit.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "fit/octave_solver.h"

namespace dermap {

using EvidenceMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kUnknownCount, kUnknownCount>;
using EvidenceVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kUnknownCount, 1>;

// What the data say of one pixel of an octave.
struct PixelEvidence {
  EvidenceMatrix normal;  // N
  EvidenceVector asked;   // b: the estimate is (N + 1/S)^-1 b
};

struct OctaveEvidence {
  std::vector<PixelEvidence> pixels;
  EvidenceVector variance;  // S
  double share = 1;         // of the pixels' dimensions that details span
};

// Where each unknown stands.
struct ChoiceStatus {
  std::vector<char> free, absent;  // by free parameter of the problem
  int free_count() const { return static_cast<int>(std::count(free.begin(), free.end(), 1)); }
};

std::vector<OctaveEvidence> CollectEvidence(const PatchProblem& problem, const FitState& state,
                                            const DetailView& detail, const SkinPoint& fixed);

// MacKay's fixed point, as Update (fit/detail_model.h) without its guess: sets of parameters are compared at
// the variances that make the data likeliest, or a parameter would be given up for what was guessed of it.
void TakeLikeliestVariance(OctaveEvidence& octave);

// As if the data did not answer to it.
void Forget(int unknown, std::vector<OctaveEvidence>& octaves);

std::vector<int> FreeIndices(const ChoiceStatus& status);

// N + 1/S of what is free.
EvidenceMatrix PrecisionOf(const PixelEvidence& pixel, const EvidenceVector& variance,
                           const std::vector<int>& free);

// Logarithm, up to a constant. `average`: of every unknown, scaled units; what is absent is that much below.
double LogEvidence(const std::vector<OctaveEvidence>& octaves, const ChoiceStatus& status,
                   const FreeVector& average);

}  // namespace dermap
