// SPDX-License-Identifier: Apache-2.0
// Evidence against evidence.
#include "fit/doubts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fit/resample.h"

namespace dermap {
namespace {

constexpr double kGross = 0.3;  // logarithm
// Logarithm of the odds, before anything is seen, that it is wrong: nobody measures the epidermis, and the
// pixel on the skin has been measured.
constexpr double kTrustInThickness = -1.6, kTrustInPixelSize = -4.6;
constexpr double kMostOff = 2.0;  // of an error found, that it may be off by
// Errors of the test, logarithm: in honest scenes it finds up to 0.03, in averages of areas up to 0.13, since
// skin that varies within them blurs less than its mean.
constexpr double kTestError = 0.02, kReducedTestError = 0.06;
// An epidermis thinner than a mean free path does little: what tables are off by looks like much of it (found
// in honest skin: 0.25 at 0.4 mean free paths, 0.38 at 0.2).
double ThicknessTestError(const ForwardModel& model) {
  double paths = 1.0;
  for (const BandOptics& optics : model.optics())
    paths =
        std::min(paths, optics.nodes[optics.center].mu_s_epidermis * model.tissue().epidermis_thickness_mm);
  return kTestError / (paths * paths);
}

constexpr double kTellsNothing = 0.1;  // of a test, its error

constexpr double kPossible = 0.05;  // probability

}  // namespace

bool Doubt::IsGross() const {
  return probability > Doubts::kLikely && std::abs(log_error) > kGross;
}

void Doubts::CheckThickness(const PatchProblem& problem, const FitState& state, const DetailView& detail,
                            const SkinPoint& fixed, std::string_view profiles) {
  const double test_error = ThicknessTestError(problem.model());
  if (problem.data().band_count() <= kUnknownCount || test_error > kTellsNothing) return;
  thickness_ = CheckAssumption(Assumption::kThickness, AnswerToThickness(problem, state, profiles), problem,
                               state, detail, fixed, test_error);
  if (!thickness_.maps.empty()) thickness_of_ = problem.space().free();
}

void Doubts::SettleThickness(const PatchProblem& problem, const FitState& state, double evidence) {
  if (thickness_of_.empty()) return;
  AssumptionCheck check = std::move(thickness_);
  std::vector<PlaneF> maps;
  for (const Parameter p : problem.space().free()) {
    const auto at = std::find(thickness_of_.begin(), thickness_of_.end(), p) - thickness_of_.begin();
    maps.push_back(std::move(check.maps[static_cast<std::size_t>(at)]));
  }
  check.maps = std::move(maps);
  Add(problem, state, check, evidence);
}

void Doubts::CheckPixelSize(const PatchProblem& problem, const FitState& state, const DetailView& detail,
                            const SkinPoint& fixed, bool reduced) {
  // Black tape bounds the light, and its size is how large a pixel is known to be; how light falls off beside
  // it is not known well enough to say it again.
  if (problem.model().conditions().tape == Tape::kBlack || problem.data().band_count() <= kUnknownCount)
    return;
  Add(problem, state,
      CheckAssumption(Assumption::kPixelSize, AnswerToPixelSize(problem, state), problem, state, detail,
                      fixed, reduced ? kReducedTestError : kTestError),
      0.0);
}

void Doubts::Add(const PatchProblem& problem, const FitState& state, const AssumptionCheck& check,
                 double evidence) {
  if (check.maps.empty()) return;
  const double trust = check.assumption == Assumption::kThickness ? kTrustInThickness : kTrustInPixelSize;
  Doubt doubt{
      check.assumption,
      check.log_error,
      check.sigma,
      1.0 / (1.0 + std::exp(-trust - std::min(check.log_evidence - evidence, check.log_evidence_seen))),
      problem.space().free(),
      {}};
  for (int j = 0; j < problem.space().count(); ++j) {
    PlaneF& shift = doubt.shift.emplace_back(check.maps[j]);
    const PlaneF& now = state.maps.Unknown(problem.space().parameter(j));
    for (std::size_t i = 0; i < shift.size(); ++i)
      shift.data()[i] -= static_cast<float>(now.data()[i] / problem.space().scale(j));
  }
  doubts_.push_back(std::move(doubt));
}

bool Doubts::IsAny() const {
  return std::any_of(doubts_.begin(), doubts_.end(),
                     [](const Doubt& doubt) { return doubt.probability > kPossible; });
}

void Doubts::AddTo(const std::vector<Parameter>& free, std::vector<PlaneF>& variance) const {
  AddTo(free, 1.0, variance);
}

void Doubts::AddUnlikelyTo(const std::vector<Parameter>& free, std::vector<PlaneF>& variance) const {
  AddTo(free, kLikely, variance);
}

void Doubts::AddTo(const std::vector<Parameter>& free, double most_likely,
                   std::vector<PlaneF>& variance) const {
  for (const Doubt& doubt : doubts_) {
    if (doubt.probability > most_likely) continue;
    for (std::size_t k = 0; k < doubt.of.size(); ++k) {
      const auto j =
          static_cast<std::size_t>(std::find(free.begin(), free.end(), doubt.of[k]) - free.begin());
      if (j == free.size()) continue;
      PlaneF square = doubt.shift[k];
      // Not by the probability itself: an interval of 95 % must reach as far as what holds once in twenty,
      // but not as far as what is rarer. And not by what was found alone, but by how far that may be off as
      // well.
      const double off = std::min(doubt.sigma / std::abs(doubt.log_error), kMostOff);
      const double reach = std::sqrt(doubt.probability) * std::min(doubt.probability / kPossible, 1.0);
      const auto weight = static_cast<float>(reach * (1.0 + off * off));
      for (float& value : square.values()) value *= weight * value;
      square = ResizeLinear(square, variance[j].width(), variance[j].height());
      for (std::size_t i = 0; i < square.size(); ++i) variance[j].data()[i] += square.data()[i];
    }
  }
}

double JunctionEvidence(const std::vector<Candidate>& candidates) {
  const auto has_junction = [](const Candidate& c) {
    return std::count(c.free.begin(), c.free.end(), Parameter::kJunctionAbsorbance) > 0;
  };
  if (candidates.empty() || !has_junction(candidates.front())) return 0.0;
  double best = -std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : candidates)
    if (!has_junction(candidate)) best = std::max(best, candidate.log_evidence);
  return candidates.front().log_evidence - best;
}

}  // namespace dermap
