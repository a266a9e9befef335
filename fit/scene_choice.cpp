// SPDX-License-Identifier: Apache-2.0
// Backward elimination.
#include "fit/scene_choice.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fit/octave_evidence.h"

namespace dermap {
namespace {

constexpr double kEvidenceToGiveUp = 1.0;  // log: what is told must be as good as known
constexpr double kToldVariance = 0.1;      // of the prior's, of a patch's mean: below, the data tell it

// One unknown less.
struct Removal {
  ChoiceStatus status;
  double evidence = 0.0, margin = 0.0;  // the second: over what is asked for
  std::size_t index = 0;                // of the candidate
};

// What giving an unknown up must gain in evidence. Where evidence is even, a value that is wrong does more
// harm to the others than a free one does; of what the data do not tell even the patch's mean there is
// nothing to lose.
std::vector<double> AskedToGiveUp(const OctaveEvidence& mean, const ChoiceStatus& status) {
  const std::vector<int> free = FreeIndices(status);
  const int count = static_cast<int>(free.size());
  const EvidenceMatrix covariance =
      Eigen::LLT<EvidenceMatrix>(PrecisionOf(mean.pixels.front(), mean.variance, free))
          .solve(EvidenceMatrix::Identity(count, count));
  std::vector<double> asked(status.free.size(), 0.0);
  for (int a = 0; a < count; ++a)
    asked[free[a]] =
        covariance(a, a) < kToldVariance * mean.variance[free[a]] ? kEvidenceToGiveUp : -kEvidenceForOne;
  return asked;
}

// Before anything is seen, most skin has no tattoo: logarithm of the odds.
constexpr double kOddsOfTattoo = -4.6;

double LogOdds(const std::vector<OctaveEvidence>& octaves, const ChoiceStatus& status,
               const ParameterSpace& space) {
  double odds = LogEvidence(octaves, status, space.mean());
  for (int j = 0; j < space.count(); ++j)
    if (status.free[j] && space.parameter(j) == Parameter::kJunctionAbsorbance) odds += kOddsOfTattoo;
  return odds;
}

// Of ink at the junction, the last of the unknowns: at the variances that the fit has. At the likeliest ones
// a trace of it would stand for errors of the model, and a trace is no tattoo.
double EvidenceOfInk(const std::vector<OctaveEvidence>& octaves, const ParameterSpace& space) {
  ChoiceStatus status{std::vector<char>(space.count(), 1), std::vector<char>(space.count(), 0)};
  const double with = LogOdds(octaves, status, space);
  status.free.back() = 0;
  return with - LogOdds(octaves, status, space);
}

Candidate CandidateOf(const ParameterSpace& space, const ChoiceStatus& status, double log_evidence) {
  Candidate candidate;
  candidate.log_evidence = log_evidence;
  for (int j = 0; j < space.count(); ++j) {
    if (status.free[j]) candidate.free.push_back(space.parameter(j));
    if (status.absent[j]) candidate.absent.push_back(space.parameter(j));
  }
  return candidate;
}

// Melanin is what every skin has; the junction without a tattoo keeps its base value.
bool MayBeAbsent(Parameter p) {
  return p == Parameter::kC_he || p == Parameter::kC_bc || p == Parameter::kC_hd;
}

// The unknown that is missed least of those that are free; all that are tried are added to `seen`. Ink was
// weighed before, so it is tried only `with_ink`.
std::optional<Removal> LeastMissed(const std::vector<OctaveEvidence>& octaves, const ChoiceStatus& status,
                                   double evidence, const ParameterSpace& space, bool with_ink,
                                   std::vector<Candidate>& seen) {
  std::optional<Removal> best;
  const std::vector<double> asked = AskedToGiveUp(octaves.back(), status);
  for (int j = 0; j < space.count(); ++j) {
    const Parameter p = space.parameter(j);
    if (!status.free[j] || p == Parameter::kC_m) continue;
    if (p == Parameter::kJunctionAbsorbance && !with_ink) continue;
    double at_average = 0.0;
    for (int absent = 0; absent <= (MayBeAbsent(p) ? 1 : 0); ++absent) {
      Removal removal{status};
      removal.status.free[j] = 0;
      removal.status.absent[j] = static_cast<char>(absent);
      removal.evidence = LogOdds(octaves, removal.status, space);
      removal.margin = removal.evidence - evidence - (absent ? -kEvidenceForOne : asked[j]);
      removal.index = seen.size();
      seen.push_back(CandidateOf(space, removal.status, removal.evidence));
      if (!absent) at_average = removal.evidence;
      if (absent && removal.evidence < at_average) continue;  // average skin's is likelier than none
      if (!best || removal.margin > best->margin) best = removal;
    }
  }
  return best;
}

}  // namespace

std::vector<Parameter> AllUnknowns() {
  std::vector<Parameter> unknowns;
  for (int i = 0; i < kUnknownCount; ++i) unknowns.push_back(static_cast<Parameter>(i));
  return unknowns;
}

std::vector<Candidate> ChooseCandidates(const PatchProblem& problem, const FitState& state,
                                        const DetailView& detail, const SkinPoint& fixed, int most) {
  const ParameterSpace& space = problem.space();
  std::vector<OctaveEvidence> octaves = CollectEvidence(problem, state, detail, fixed);
  ChoiceStatus status{std::vector<char>(space.count(), 1), std::vector<char>(space.count(), 0)};
  std::vector<Candidate> seen;
  const double ink = space.HasJunction() ? EvidenceOfInk(octaves, space) : 0.0;
  const int junction = space.HasJunction() ? space.count() - 1 : -1;
  ChoiceStatus other = status;
  if (junction >= 0) (ink > kEvidenceForOne ? other : status).free[junction] = 0;
  if (junction >= 0 && !status.free[junction]) Forget(junction, octaves);
  for (std::size_t l = 0; l + 1 < octaves.size(); ++l) TakeLikeliestVariance(octaves[l]);
  double evidence = LogOdds(octaves, status, space);
  if (junction >= 0)
    seen.push_back(CandidateOf(space, other, evidence + (status.free[junction] ? -ink : ink)));
  std::size_t chosen = seen.size();
  seen.push_back(CandidateOf(space, status, evidence));
  while (status.free_count() > 1) {
    const std::optional<Removal> best =
        LeastMissed(octaves, status, evidence, space, status.free_count() > most, seen);
    if (!best || (status.free_count() <= most && best->margin < 0.0)) break;
    status = best->status;
    evidence = best->evidence;
    chosen = best->index;
  }
  std::swap(seen[0], seen[chosen]);
  std::stable_sort(seen.begin() + 1, seen.end(),
                   [](const Candidate& a, const Candidate& b) { return a.log_evidence > b.log_evidence; });
  const double top = std::max_element(seen.begin(), seen.end(), [](const Candidate& a, const Candidate& b) {
                       return a.log_evidence < b.log_evidence;
                     })->log_evidence;
  for (Candidate& candidate : seen) candidate.log_evidence -= top;
  return seen;
}

bool LacksBands(const std::vector<Candidate>& candidates, int band_count) {
  const Candidate& chosen = candidates.front();
  const auto all =
      std::max_element(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.free.size() < b.free.size(); });
  const auto given_up = static_cast<double>(all->free.size() - chosen.free.size());
  return band_count <= kUnknownCount || all->log_evidence - chosen.log_evidence > kEvidenceForOne * given_up;
}

std::string NamesOf(const std::vector<Parameter>& parameters) {
  std::string names;
  for (const Parameter p : parameters) names += (names.empty() ? "" : ", ") + std::string(InfoOf(p).name);
  return names;
}

}  // namespace dermap
