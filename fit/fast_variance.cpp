// SPDX-License-Identifier: Apache-2.0
// Variances with nothing held fixed.
#include "fit/fast_variance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/map_steps.h"

namespace dermap {
namespace {

constexpr double kUnevenness = 0.15;
constexpr double kNoOffset = 1e-3;    // scaled units: least that what is fixed may be off
constexpr double kSmallest = 1e-12;   // variance, scaled units
constexpr double kNoEvidence = 1e3;   // log, of a kind of set that was not weighed
constexpr double kMuchScatter = 4.0;  // of residuals over noise, variances

bool Holds(const std::vector<Parameter>& free, Parameter p) {
  return std::count(free.begin(), free.end(), p) > 0;
}

// Skin either has ink or has none: by the evidence for ink that the junction was given up in spite of.
double ProbabilityOfInk(const std::vector<Candidate>& candidates) {
  double with = -kNoEvidence, without = -kNoEvidence;
  for (const Candidate& candidate : candidates) {
    double& best = Holds(candidate.free, Parameter::kJunctionAbsorbance) ? with : without;
    best = std::max(best, candidate.log_evidence);
  }
  return 1.0 / (1.0 + std::exp(without - with));
}

// What is not free differs from its fixed value about as much as the fit with all free found: the evidence
// says that this is little, not that it is nothing.
void TakeFixedAsFound(const PatchProblem& problem, const FitState& state, const std::vector<Parameter>& free,
                      const SkinPoint& fixed, FreeVector& mean_variance) {
  const ParameterSpace& space = problem.space();
  for (int j = 0; j < space.count(); ++j) {
    if (Holds(free, space.parameter(j))) continue;
    double sum = 0.0;
    const PlaneF& plane = state.maps.Unknown(space.parameter(j));
    for (const float value : plane.values()) sum += value;
    const double offset =
        (sum / static_cast<double>(plane.size()) - fixed[static_cast<int>(space.parameter(j))]) /
        space.scale(j);
    mean_variance[j] = offset * offset;
  }
}

// No skin is as even as a map of one value: what is present but not free varies by kUnevenness of its value,
// in all octaves together, even where the data are silent about it. The junction without ink is no content of
// skin but a constant of the model.
void LeaveFixedUneven(const ParameterSpace& space, const FastOutcome& outcome, std::span<FreeVector> prior) {
  const auto octaves = static_cast<double>(prior.size() - 1);
  for (int j = 0; j < space.count(); ++j) {
    const Parameter p = space.parameter(j);
    if (Holds(outcome.free, p) || p == Parameter::kJunctionAbsorbance) continue;
    const double value = outcome.fixed[static_cast<int>(space.parameter(j))] / space.scale(j);
    for (std::size_t octave = 0; octave + 1 < prior.size(); ++octave)
      prior[octave][j] = std::max(prior[octave][j], std::pow(kUnevenness * value, 2) / octaves);
  }
}

// What all pixels of a band share counts as so much larger, and with it what the mean's residuals showed of
// it: a handful of numbers may miss as much again.
std::vector<PlaneF> VarianceAllowedFor(const PatchProblem& problem, const FitState& state,
                                       const DetailView& detail, const SkinPoint& fixed) {
  const FitData& data = problem.data();
  const double allowed = data.shared_error_allowance * data.shared_error;
  return SolveInOctaves(problem, LineariseInOctaves(problem, state, allowed), detail, fixed).variance;
}

}  // namespace

void FastVariance::HoldFixed(const PatchProblem& problem, const FitState& state, const DetailModel& detail,
                             const std::vector<Candidate>& candidates, const SkinPoint& fixed, int octave,
                             bool found) {
  seen_from_ = octave;
  detail_ = detail;
  ink_ = ProbabilityOfInk(candidates);
  mean_ink_ = problem.data().shared_error < kSharedError ? ink_ : 1.0;
  if (found) TakeFixedAsFound(problem, state, candidates.front().free, fixed, detail_->prior.back());
}

// Of ink that is as likely as there is any; unless something is told wrong, and with it the odds. A gray
// shift of the mean is also what errors of calibration look like that are larger than the stack knows: it
// stays allowed where bands are known no better than by default.
void FastVariance::ThinInk(const FastOutcome& outcome, double in_mean, std::span<FreeVector> prior) const {
  constexpr auto kInk = static_cast<std::size_t>(Parameter::kJunctionAbsorbance);
  if (!Holds(outcome.free, Parameter::kJunctionAbsorbance) && !outcome.doubts.IsAny())
    for (FreeVector& octave : prior)
      octave[kInk] = std::max((&octave == &prior.back() ? in_mean : ink_) * octave[kInk], kSmallest);
  for (int j = 0; j < kUnknownCount; ++j)
    if (!Holds(outcome.free, static_cast<Parameter>(j)))
      prior.back()[j] = std::max(prior.back()[j], kNoOffset * kNoOffset);
}

DetailModel FastVariance::DetailOfAll(const FastOutcome& outcome, int first) const {
  DetailModel model = *detail_;
  model.scatter = outcome.detail.scatter;
  model.activity = outcome.detail.activity;
  const DetailView detail = ViewFrom(model, first);
  for (int octave = seen_from_ - 1; octave >= first; --octave)
    for (int j = 0; j < kUnknownCount; ++j)
      detail.prior[octave - first][j] = GuessedVariance(detail, octave - first, j);
  for (std::size_t octave = 0; octave < detail.prior.size(); ++octave)
    for (std::size_t k = 0; k < outcome.free.size(); ++k) {
      const auto p = static_cast<std::size_t>(outcome.free[k]);
      detail.prior[octave][p] = outcome.detail.prior[octave + first][k];
      detail.details[octave][p] = outcome.detail.details[octave + first][k];
    }
  return model;
}

std::vector<PlaneF> FastVariance::WithAll(const PatchProblem& problem, const FastOutcome& outcome,
                                          DetailModel model, int first) const {
  const PatchProblem all(problem.data(), problem.model(), ParameterSpace(AllUnknowns()));
  FitState state = outcome.state;
  state.maps = WithJunction(std::move(state.maps), outcome.fixed[kParameterCount]);
  const DetailView detail = ViewFrom(model, first);
  LeaveFixedUneven(all.space(), outcome, detail.prior);
  std::vector<PlaneF> of_all = VarianceAllowedFor(all, state, detail, outcome.fixed), variance;
  for (const Parameter p : outcome.free) variance.push_back(std::move(of_all[static_cast<std::size_t>(p)]));
  return variance;
}

std::vector<PlaneF> FastVariance::Of(const PatchProblem& problem, const FastOutcome& outcome, int first,
                                     OctaveStep& last) const {
  if (!IsAnyHeld(outcome)) {
    if (problem.data().shared_error_allowance == 1.0) return std::move(last.variance);
    DetailModel model = outcome.detail;
    return VarianceAllowedFor(problem, outcome.state, ViewFrom(model, first), outcome.fixed);
  }
  DetailModel all = DetailOfAll(outcome, first);
  ThinInk(outcome, mean_ink_, all.prior);
  return WithAll(problem, outcome, std::move(all), first);
}

std::vector<PlaneF> FastVariance::OfNoise(const PatchProblem& problem, const FastOutcome& outcome,
                                          int first) const {
  const std::vector<double>& scatter = outcome.detail.scatter;
  if (!outcome.doubts.IsAny() && *std::max_element(scatter.begin() + first, scatter.end()) < kMuchScatter)
    return {};
  const bool held = IsAnyHeld(outcome);
  DetailModel quiet = held ? DetailOfAll(outcome, first) : outcome.detail;
  if (held) ThinInk(outcome, ink_, quiet.prior);  // as if calibration were right
  std::fill(quiet.scatter.begin(), quiet.scatter.end(), 1.0);
  std::vector<PlaneF> variance =
      held ? WithAll(problem, outcome, std::move(quiet), first)
           : VarianceAllowedFor(problem, outcome.state, ViewFrom(quiet, first), outcome.fixed);
  outcome.doubts.AddUnlikelyTo(outcome.free, variance);
  return variance;
}

}  // namespace dermap
