// SPDX-License-Identifier: Apache-2.0
// What a fit was told and the data speak against, and what that would change in the maps.
#pragma once

#include <vector>

#include "fit/assumptions.h"
#include "fit/candidate.h"
#include "fit/options.h"

namespace dermap {

struct Doubt {
  Assumption assumption = Assumption::kPixelSize;
  double log_error = 0.0, sigma = 0.0;  // logarithm of the true value over the told one
  double probability = 0.0;             // that this, and not what the fit took for it, explains the data
  std::vector<Parameter> of;            // what was free then
  std::vector<PlaneF> shift;            // of each of them, if so: scaled units, at any size

  // Further off than the maps' answer is close to linear: what they would be is a guess.
  bool IsGross() const;
};

// With no more bands than unknowns nothing is left that could speak against anything, and nothing is doubted.
class Doubts {
 public:
  // At the coarsest size, before anything else is made of what a wrong thickness leaves: a band's gain, or
  // the junction's absorbance.
  void CheckThickness(const PatchProblem& problem, const FitState& state, const DetailView& detail,
                      const SkinPoint& fixed, std::string_view profiles);
  // At the same size once the maps have settled. `evidence`: logarithm of that for what was made of it.
  void SettleThickness(const PatchProblem& problem, const FitState& state, double evidence);
  // `reduced`: whether the data are averages of areas, in which skin varies.
  void CheckPixelSize(const PatchProblem& problem, const FitState& state, const DetailView& detail,
                      const SkinPoint& fixed, bool reduced);

  const std::vector<Doubt>& all() const { return doubts_; }
  bool IsAny() const;
  // Above kLikely it is said, and counts against the fit.
  static constexpr double kLikely = 0.9;
  // The squares of the shifts, by the root of how likely the data make them. `variance`: of each free
  // parameter, scaled units.
  void AddTo(const std::vector<Parameter>& free, std::vector<PlaneF>& variance) const;
  // Those that are not likely alone.
  void AddUnlikelyTo(const std::vector<Parameter>& free, std::vector<PlaneF>& variance) const;

 private:
  void AddTo(const std::vector<Parameter>& free, double most_likely, std::vector<PlaneF>& variance) const;
  void Add(const PatchProblem& problem, const FitState& state, const AssumptionCheck& check, double evidence);

  std::vector<Doubt> doubts_;
  AssumptionCheck thickness_;
  std::vector<Parameter> thickness_of_;  // what was free then
};

// Logarithm by which the data prefer that the junction's absorbance is free.
double JunctionEvidence(const std::vector<Candidate>& candidates);

}  // namespace dermap
