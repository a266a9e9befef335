// SPDX-License-Identifier: Apache-2.0
// Coarse to fine.
#include "fit/fast.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "fit/fast_variance.h"
#include "fit/local_start.h"
#include "fit/map_steps.h"
#include "fit/octave_solver.h"
#include "fit/resample.h"
#include "fit/size_fit.h"

namespace dermap {
namespace {

// A size is done once a step moves the maps by less than this share of their standard deviations.
constexpr double kRest = 0.15, kCoarseRest = 0.4;
constexpr double kUnexplained = 4.0;       // chi2 a datum that calls for a search among the bands
constexpr double kMostlyExplained = 0.25;  // of it may stay once the culprit is left out
constexpr double kGainsAtWork = 0.2;       // share of chi2 below which no gain is searched for
constexpr double kUnsettled = 1.25;        // chi2 a datum above which more is freed than was chosen
constexpr double kSettled = 0.8;           // of chi2, at most, must stay for that
constexpr int kCheckedSize = 64;           // pixels along the longer side, at which the pixels' is doubted
constexpr int kMostSuspicions = 3;         // corrections of a band's gain, each a smaller one

// Halved, rounding up, as the octaves are.
std::vector<int> Sizes(int size) {
  std::vector<int> sizes{size};
  while ((sizes.back() + 1) / 2 >= kCoarsestSize) sizes.push_back((sizes.back() + 1) / 2);
  std::reverse(sizes.begin(), sizes.end());
  return sizes;
}

class CoarseToFine {
 public:
  CoarseToFine(FitData& data, const ForwardModel& model, const ModelMaker& make_model,
               const FitOptions& options, RunLog& log)
      : data_(data), model_(model), make_model_(make_model), options_(options), log_(log) {}

  FastOutcome Run(const std::vector<Parameter>& free) {
    const std::vector<int> sizes = Sizes(std::max(data_.width(), data_.height()));
    outcome_.free = free;
    outcome_.fixed = PointOf(options_.prior ? options_.prior->mean : options_.fixed_values,
                             model_.tissue().junction_absorbance);
    for (std::size_t s = 0; s < sizes.size(); ++s) {
      const bool finest = s + 1 == sizes.size();
      const int first = static_cast<int>(sizes.size() - 1 - s);  // octave of this size's pixels
      FitData reduced;
      std::optional<ForwardModel> coarse_model;
      if (!finest) {
        reduced = ReduceData(data_, sizes[s], 1);
        AddRelativeError(reduced, kReductionError);
        coarse_model.emplace(make_model_(reduced.conditions));
      }
      FitData& data = finest ? data_ : reduced;
      const ForwardModel& model = finest ? model_ : *coarse_model;
      if (s == 0) Begin(data, model, first);
      FitSize(data, model, first, finest);
      log_.Progress((s + 1.0) / static_cast<double>(sizes.size()));
    }
    return std::move(outcome_);
  }

 private:
  // The coarsest size: a band with a wrong gain is found and set right, and where nothing else is asked for
  // it is chosen what is free.
  void Begin(FitData& data, const ForwardModel& model, int first) {
    const bool choose = outcome_.free.empty();
    seen_from_ = first;
    if (choose) outcome_.free = AllUnknowns();
    PatchProblem problem(data, model, ParameterSpace(outcome_.free));
    outcome_.state.maps = InvertLocally(problem, TableOne(outcome_.fixed));
    const int octaves = static_cast<int>(OctaveShapes(data_.width(), data_.height()).size());
    outcome_.detail =
        FirstDetailModel(octaves, MeasureBlur(model_, SkinsOf(problem, outcome_.state.maps), octaves - 1),
                         LinkOf(problem.space()));
    outcome_.state = problem.StateOf(std::move(outcome_.state.maps));
    const DetailView detail = ViewFrom(outcome_.detail, first);
    SizeFit fit(problem, detail, outcome_.fixed);
    OctaveStep last;
    fit.Refine(outcome_.state, kCoarseRest, log_, last);
    outcome_.doubts.CheckThickness(problem, outcome_.state, detail, outcome_.fixed, options_.profiles);
    if (outcome_.state.misfit.Chi2PerDatum() > kUnexplained) LeaveOneOut(data, model, first);
    for (int again = 0; again < kMostSuspicions; ++again) {
      const auto suspect = FindSuspectBand(problem, LineariseInOctaves(problem, outcome_.state), detail,
                                           outcome_.fixed, outcome_.suspect ? kQuietGain : kLoudGain);
      if (!suspect || (outcome_.suspect && outcome_.suspect->band != suspect->band)) break;
      SetRight(*suspect, data);
      outcome_.state = problem.StateOf(std::move(outcome_.state.maps));
      fit.Refine(outcome_.state, kCoarseRest, log_, last);
    }
    if (!choose) return;
    outcome_.candidates =
        ChooseCandidates(problem, outcome_.state, detail, outcome_.fixed, data.band_count());
    const Candidate& chosen = outcome_.candidates.front();
    outcome_.free = chosen.free;
    outcome_.fixed = FixedBy(chosen, outcome_.fixed);
    variance_.HoldFixed(problem, outcome_.state, outcome_.detail, outcome_.candidates, outcome_.fixed, first,
                        !LacksBands(outcome_.candidates, data.band_count()));
    const ParameterSpace space(outcome_.free);
    KeepFree(problem.space(), space, outcome_.detail);
    outcome_.state.maps = WithFixed(space, outcome_.state.maps, outcome_.fixed);
    log_.renders_before += problem.renders();
  }

  std::optional<LinkedPrior> LinkOf(const ParameterSpace& space) const {
    return options_.prior ? std::optional(LinkTo(*options_.prior, space)) : std::nullopt;
  }

  // Where all bands together make no sense: is there one without which they do? A fit without each tells; one
  // gross error can lead the fit with all bands too far astray for the check of the mean.
  void LeaveOneOut(FitData& data, const ForwardModel& model, int first) {
    const PatchProblem all(data, model, ParameterSpace(outcome_.free));
    if (data.band_count() < kParameterCount + 2 || ShareOfGains(data, outcome_.state) < kGainsAtWork) return;
    std::optional<FastOutcome> best;
    double least = kMostlyExplained * outcome_.state.misfit.Chi2PerDatum();
    SuspectBand suspect;
    for (int b = 0; b < data.band_count() && !log_.Stopped(); ++b) {
      FitData without = data;
      for (float& value : without.measured[b].values()) value = std::numeric_limits<float>::quiet_NaN();
      PatchProblem problem(without, model, all.space());
      FastOutcome trial;
      trial.detail = FirstDetailModel(static_cast<int>(outcome_.detail.prior.size()), outcome_.detail.blur,
                                      outcome_.detail.link);
      trial.state = problem.StateOf(InvertLocally(problem, TableOne(outcome_.fixed)));
      OctaveStep last;
      SizeFit(problem, ViewFrom(trial.detail, first), outcome_.fixed)
          .Refine(trial.state, kCoarseRest, log_, last);
      log_.renders_before += problem.renders();
      if (trial.state.misfit.Chi2PerDatum() > least) continue;
      least = trial.state.misfit.Chi2PerDatum();
      suspect = {b, GainError(data, b, trial.state.predicted[b]),
                 0.5 * (outcome_.state.misfit.chi2 - trial.state.misfit.chi2)};
      best = std::move(trial);
    }
    if (!best || std::abs(suspect.gain_error) < kLoudGain) return;
    SetRight(suspect, data);
    std::copy(best->detail.prior.begin(), best->detail.prior.end(), outcome_.detail.prior.begin());
    std::copy(best->detail.scatter.begin(), best->detail.scatter.end(), outcome_.detail.scatter.begin());
    std::move(best->detail.activity.begin(), best->detail.activity.end(), outcome_.detail.activity.begin());
    outcome_.state = PatchProblem(data, model, all.space()).StateOf(std::move(best->state.maps));
  }

  // Divides the band by its gain error, here and at full size.
  void SetRight(const SuspectBand& suspect, FitData& data) {
    const double gain = 1.0 + suspect.gain_error;
    const double before = outcome_.suspect ? outcome_.suspect->gain_error : 0.0;
    const double evidence = outcome_.suspect ? outcome_.suspect->log_evidence : 0.0;
    outcome_.suspect =
        SuspectBand{suspect.band, (1.0 + before) * gain - 1.0, evidence + suspect.log_evidence};
    for (FitData* of : {&data, &data_}) {
      for (float& value : of->measured[suspect.band].values()) value = static_cast<float>(value / gain);
      for (float& value : of->sigma[suspect.band].values()) value = static_cast<float>(value / gain);
      if (&data == &data_) break;
    }
  }

  void FitSize(const FitData& data, const ForwardModel& model, int first, bool finest) {
    PatchProblem problem(data, model, ParameterSpace(outcome_.free));
    const DetailView detail = ViewFrom(outcome_.detail, first);
    ParameterMaps& start = outcome_.state.maps;
    if (start.width() != data.width() || start.height() != data.height()) {
      start = Enlarged(problem, start);
      for (int j = 0; j < problem.space().count(); ++j) detail.prior[0][j] = GuessedVariance(detail, 0, j);
      detail.activity[0] = Enlarged(detail.activity[1], {data.width(), data.height()});
    }
    outcome_.state = problem.StateOf(std::move(start));
    if (finest && options_.resume) TakeUp(problem);
    log_.Add(outcome_.state.misfit, problem.space().count(), problem.renders());
    OctaveStep last;
    outcome_.converged = SizeFit(problem, detail, outcome_.fixed)
                             .Refine(outcome_.state, finest ? kRest : kCoarseRest, log_, last);
    log_.renders_before += problem.renders();
    if (first == seen_from_)
      outcome_.doubts.SettleThickness(
          problem, outcome_.state,
          JunctionEvidence(outcome_.candidates) + (outcome_.suspect ? outcome_.suspect->log_evidence : 0.0));
    const int longer = std::max(data.width(), data.height());
    if (longer <= kCheckedSize && (finest || 2 * longer - 1 > kCheckedSize))
      outcome_.doubts.CheckPixelSize(problem, outcome_.state, detail, outcome_.fixed, !finest);
    if (finest && !FreeAll(data, model, first)) Finish(problem, first, last);
  }

  // More than was chosen may be at work: the coarsest size, whose areas are averaged no better than
  // kReductionError, cannot see it where the noise is less.
  bool FreeAll(const FitData& data, const ForwardModel& model, int first) {
    if (!variance_.IsAnyHeld(outcome_) || data.band_count() <= kUnknownCount || log_.Stopped() ||
        outcome_.state.misfit.Chi2PerDatum() < kUnsettled)
      return false;
    PatchProblem problem(data, model, ParameterSpace(AllUnknowns()));
    DetailModel all = variance_.DetailOfAll(outcome_, first);
    FitState state = problem.StateOf(WithJunction(outcome_.state.maps, outcome_.fixed[kParameterCount]));
    OctaveStep last;
    const bool converged =
        SizeFit(problem, ViewFrom(all, first), outcome_.fixed).Refine(state, kRest, log_, last);
    log_.renders_before += problem.renders();
    if (state.misfit.chi2 > kSettled * outcome_.state.misfit.chi2) return false;
    outcome_.converged = converged;
    outcome_.freed_late = true;
    outcome_.free = AllUnknowns();
    outcome_.detail = std::move(all);
    outcome_.state = std::move(state);
    variance_ = {};
    Finish(problem, first, last);
    return true;
  }

  void Finish(const PatchProblem& problem, int first, OctaveStep& last) {
    outcome_.variance = variance_.Of(problem, outcome_, first, last);
    outcome_.doubts.AddTo(outcome_.free, outcome_.variance);
    outcome_.noise_variance = variance_.OfNoise(problem, outcome_, first);
    outcome_.adapted_parameters = last.adapted_parameters;
    for (std::size_t l = 0; l < last.statistics.size(); ++l) {
      FreeVector& spread = outcome_.spread.emplace_back(FreeVector{});
      for (int j = 0; j < problem.space().count(); ++j) {
        const double undecided = 1.0 - last.statistics[l].determined[j] / last.statistics[l].pixels;
        spread[j] = std::sqrt(outcome_.detail.prior[l + static_cast<std::size_t>(first)][j] *
                              std::clamp(undecided, 1e-6, 1.0));
      }
    }
  }

  // The maps of an interrupted fit, where they explain more than those of the coarser size.
  void TakeUp(PatchProblem& problem) {
    const ParameterMaps& before = options_.resume->maps;
    if (before.width() != problem.data().width() || before.height() != problem.data().height()) return;
    ParameterMaps maps = WithFixed(problem.space(), before, outcome_.fixed);
    if (problem.space().HasJunction() && maps.junction_absorbance.size() != 1) return;
    FitState state = problem.StateOf(std::move(maps));
    if (state.misfit.chi2 < outcome_.state.misfit.chi2) outcome_.state = std::move(state);
  }

  FitData& data_;
  const ForwardModel& model_;
  const ModelMaker& make_model_;
  const FitOptions& options_;
  RunLog& log_;
  FastOutcome outcome_;
  FastVariance variance_;
  int seen_from_ = 0;  // octave of the coarsest size's pixels
};

}  // namespace

FastOutcome FitCoarseToFine(FitData& data, const ForwardModel& model, const std::vector<Parameter>& free,
                            const ModelMaker& make_model, const FitOptions& options, RunLog& log) {
  return CoarseToFine(data, model, make_model, options, log).Run(free);
}

}  // namespace dermap
