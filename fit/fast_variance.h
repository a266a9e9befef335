// SPDX-License-Identifier: Apache-2.0
// Error bars of the fast fit: what is held fixed is an assumption, and sigma holds how far it may be off.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fit/fast.h"
#include "fit/octave_solver.h"

namespace dermap {

class FastVariance {
 public:
  // At the coarsest size, with a state in which all unknowns are free and what was then weighed. `detail`: of
  // all unknowns. `found`: whether what that fit found of the others says how far they may be off.
  void HoldFixed(const PatchProblem& problem, const FitState& state, const DetailModel& detail,
                 const std::vector<Candidate>& candidates, const SkinPoint& fixed, int octave, bool found);

  bool IsAnyHeld(const FastOutcome& outcome) const {
    return detail_ && outcome.free.size() < static_cast<std::size_t>(kUnknownCount);
  }
  // Of all unknowns at the end: what is free as the fit found it.
  DetailModel DetailOfAll(const FastOutcome& outcome, int first) const;

  // Of what is free at the end, scaled units; `last`: of the step that came to rest. `first`: octave of the
  // problem's pixels.
  std::vector<PlaneF> Of(const PatchProblem& problem, const FastOutcome& outcome, int first,
                         OctaveStep& last) const;

  // What noise alone would leave, where more was found; else nothing.
  std::vector<PlaneF> OfNoise(const PatchProblem& problem, const FastOutcome& outcome, int first) const;

 private:
  std::vector<PlaneF> WithAll(const PatchProblem& problem, const FastOutcome& outcome, DetailModel all,
                              int first) const;

  void ThinInk(const FastOutcome& outcome, double in_mean, std::span<FreeVector> prior) const;

  std::optional<DetailModel> detail_;  // of all unknowns; nothing: what is free was not chosen
  double ink_ = 1.0, mean_ink_ = 1.0;  // the probability of any at the junction, in details and the mean
  int seen_from_ = 0;                  // octave of the coarsest size's pixels
};

}  // namespace dermap
