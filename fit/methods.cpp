// SPDX-License-Identifier: Apache-2.0
// Methods run, and what they found said.
#include "fit/methods.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "fit/ceres_reference.h"
#include "fit/descent.h"
#include "fit/free_under_prior.h"
#include "fit/start_maps.h"
#include "fit/uncertainty.h"

namespace dermap {
namespace {

constexpr double kLoudScatter = 1.2;  // of residuals over noise, variances: above it the fit says so
// Between descent and fast, squared, over the variance of a pixel by itself: as far as its noise explains.
constexpr double kNoiseDistance = 4.0;

template <class... Args>
std::string Format(const char* format, Args... args) {
  char text[360];
  std::snprintf(text, sizeof text, format, args...);
  return text;
}

void SayWhatIsFree(const FastOutcome& fast, int band_count, RunLog& log) {
  const Candidate& chosen = fast.candidates.front();
  std::vector<Parameter> fixed;
  for (const Parameter p : AllUnknowns())
    if (std::count(chosen.free.begin(), chosen.free.end(), p) == 0 &&
        std::count(chosen.absent.begin(), chosen.absent.end(), p) == 0)
      fixed.push_back(p);
  std::string sentence = "The evidence asks for " + NamesOf(chosen.free) + " to be free";
  if (!fixed.empty()) sentence += "; at average skin's value: " + NamesOf(fixed);
  if (!chosen.absent.empty()) sentence += "; absent: " + NamesOf(chosen.absent);
  log.Decide(sentence + ".");
  if (LacksBands(fast.candidates, band_count))
    log.Decide(
        "With so few bands the maps hang on the values of what is fixed; sigma holds how far those may be "
        "off.");
}

bool IsGrosslyTold(const FastOutcome& fast) {
  return std::any_of(fast.doubts.all().begin(), fast.doubts.all().end(),
                     [](const Doubt& doubt) { return doubt.IsGross(); });
}

void SayWhatWasFound(const FastOutcome& fast, const FitData& data, RunLog& log) {
  if (fast.suspect)
    log.Decide(Format(
        "Band %.0f nm is %.1f %% too %s against all others (is its gain, exposure or filter wrong?); the fit "
        "divided it by that.",
        data.bands[fast.suspect->band].wavelength_nm, 100.0 * std::abs(fast.suspect->gain_error),
        fast.suspect->gain_error > 0.0 ? "bright" : "dark"));
  for (const Doubt& doubt : fast.doubts.all())
    if (doubt.probability > Doubts::kLikely)
      log.Decide(Format(
          doubt.assumption == Assumption::kPixelSize
              ? "Detail is blurred as if pixels were %.2f times the size told (give or take %.0f %%): is "
                "pixel_size right, and the picture sharp? Sigma was widened by what that would change."
              : "The data speak for an epidermis %.2f times as thick as told (give or take %.0f %%); sigma "
                "was widened by what that would change.",
          std::exp(doubt.log_error), 100.0 * doubt.sigma));
  if (fast.freed_late)
    log.Decide("At full size that left too much of the data unexplained: all parameters were freed.");
  if (fast.detail.scatter[0] > kLoudScatter)
    log.Decide(
        Format("Residuals scatter %.2f times as far as the stated noise; sigma was widened by as much.",
               std::sqrt(fast.detail.scatter[0])));
}

MethodOutcome OutcomeOf(FastOutcome fast) {
  MethodOutcome outcome;
  outcome.free = std::move(fast.free);
  outcome.state = std::move(fast.state);
  outcome.converged = fast.converged;
  outcome.adapted_parameters = fast.adapted_parameters;
  outcome.variance = std::move(fast.variance);
  outcome.noise_variance = std::move(fast.noise_variance);
  outcome.scatter = fast.detail.scatter[0];
  outcome.grossly_told = IsGrosslyTold(fast);
  outcome.candidates = std::move(fast.candidates);
  return outcome;
}

// The fast fit's variances hold also what all pixels share and what it was told; the reference's the lateral
// coupling to the letter.
void TakeLarger(const std::vector<PlaneF>& other, std::vector<PlaneF>& variance) {
  for (std::size_t j = 0; j < variance.size(); ++j)
    for (std::size_t i = 0; i < variance[j].size(); ++i)
      variance[j].data()[i] = std::max(variance[j].data()[i], other[j].data()[i]);
}

// The paper's method knows pixels one by one. What all pixels share, and what was told, the fast fit of the
// same data tells. What residuals show of that beyond noise adds to a pixel's own sigma in full, not in
// squares: it is one error for all pixels, and most of them must be covered even where it is large. Whether a
// pixel is identifiable goes by the larger of both alone: where the fast fit, whose noise is small, says that
// the mean is told, noise is what decides. A pixel's own noise keeps it within two sigma of the fast fit's;
// where it is farther, sigma grows until 95 % intervals reach there.
void DoubtByFast(const FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                 const FitOptions& options, const PatchProblem& problem, MethodOutcome& outcome,
                 RunLog& log) {
  FitData copy = data;
  FitOptions anew = options;
  anew.resume.reset();
  RunLog fast_log({}, options.stop);
  const ParameterSpace& space = problem.space();
  FastOutcome fast = FitCoarseToFine(copy, model, space.free(), make_model, anew, fast_log);
  log.renders_before += fast_log.renders_before;
  if (fast_log.Stopped()) return;
  SayWhatWasFound(fast, data, log);
  outcome.scatter = fast.detail.scatter[0];
  // At the fast fit's maps: where a pixel's own noise has moved its blood, it would move its sigma too.
  const ParameterMaps sigma = StandardDeviations(problem, fast.state);
  for (int j = 0; j < space.count(); ++j) {
    const Parameter p = space.parameter(j);
    const PlaneF &here = outcome.state.maps.Unknown(p), &there = fast.state.maps.Unknown(p);
    PlaneF variance = fast.variance[static_cast<std::size_t>(j)], apart = variance;
    PlaneF* noise = fast.noise_variance.empty() ? nullptr : &fast.noise_variance[static_cast<std::size_t>(j)];
    for (std::size_t i = 0; i < variance.size(); ++i) {
      const double of_pixel = std::pow(sigma.Unknown(p).data()[i] / space.scale(j), 2);
      const double distance = (here.data()[i] - there.data()[i]) / space.scale(j);
      const double beyond_noise = std::max(distance * distance - kNoiseDistance * of_pixel, 0.0);
      const double shared = variance.data()[i], quiet = noise ? noise->data()[i] : shared;
      const double own = quiet + outcome.scatter * of_pixel, found = std::max(shared - quiet, 0.0);
      apart.data()[i] = static_cast<float>(std::max(own, found) + beyond_noise);
      variance.data()[i] = static_cast<float>(own + found + 2.0 * std::sqrt(own * found) + beyond_noise);
      if (noise) noise->data()[i] += static_cast<float>(of_pixel + beyond_noise);
    }
    outcome.variance.push_back(std::move(variance));
    outcome.telling_variance.push_back(std::move(apart));
  }
  outcome.noise_variance = std::move(fast.noise_variance);
  outcome.grossly_told = IsGrosslyTold(fast);
}

}  // namespace

MethodOutcome RunDescent(const FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                         const std::vector<Parameter>& free, const FitOptions& options, RunLog& log) {
  PatchProblem problem(data, model, ParameterSpace(free));
  ParameterMaps start =
      StartMaps(problem, PointOf(options.fixed_values, model.tissue().junction_absorbance), options, log);
  DescentOutcome descent = Descend(problem, std::move(start), options, log);
  log.renders_before += problem.renders();
  log.Decide(Format(
      "Degrees of freedom: data less %.1f parameters a fitted pixel, the share of %d that simulated fits "
      "adapted to.",
      descent.state.misfit.adapted_share * problem.space().count(), problem.space().count()));
  MethodOutcome outcome;
  outcome.free = problem.space().free();
  outcome.state = std::move(descent.state);
  outcome.converged = descent.converged;
  if (!log.Stopped() && !options.prior) DoubtByFast(data, model, make_model, options, problem, outcome, log);
  return outcome;
}

MethodOutcome RunFast(FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                      const FitOptions& options, RunLog& log) {
  if (options.start == StartPoint::kRandom)
    log.Decide("The fast fit always starts from the closed-form inversion: --start random was not followed.");
  FastOutcome fast = FitCoarseToFine(data, model, AskedFor(options), make_model, options, log);
  if (!fast.candidates.empty()) SayWhatIsFree(fast, data.band_count(), log);
  log.Decide(Format("Degrees of freedom: the data decide %.2f parameters a pixel; the rest is prior.",
                    fast.adapted_parameters / static_cast<double>(fast.state.misfit.chi2_map.size())));
  SayWhatWasFound(fast, data, log);
  return OutcomeOf(std::move(fast));
}

MethodOutcome RunReference(FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                           const FitOptions& options, RunLog& log) {
  FastOutcome fast = FitCoarseToFine(data, model, options.free_parameters, make_model, options, log);
  if (!fast.candidates.empty()) SayWhatIsFree(fast, data.band_count(), log);
  PatchProblem problem(data, model, ParameterSpace(fast.free));
  const DetailView detail = ViewFrom(fast.detail, 0);
  const Posterior posterior(problem, detail, fast.fixed);
  const double objective = posterior.Value(posterior.PositionOf(fast.state.maps));
  const bool dense = data.fitted.size() <= kDensePixels;
  if (log.Stopped()) {
    fast.converged = false;
    return OutcomeOf(std::move(fast));
  }
  FitOptions local = options;
  if (options.start != StartPoint::kRandom) local.start = StartPoint::kLocal;
  const bool from_fast = options.resume || (!dense && options.start != StartPoint::kRandom);
  const ParameterMaps start = from_fast ? fast.state.maps : StartMaps(problem, fast.fixed, local, log);
  ReferenceOutcome reference =
      dense ? MinimiseDense(posterior, detail, start, options.max_iterations, log)
            : MinimiseByGradient(posterior, start, fast.spread, options.max_iterations, log);
  log.Decide(Format("%s ended at an objective of %.1f after %d evaluations; the fast fit's maps have %.1f.",
                    dense ? "Levenberg-Marquardt with the dense Jacobian" : "L-BFGS with the adjoint",
                    reference.objective, reference.evaluations, objective));
  MethodOutcome outcome = OutcomeOf(std::move(fast));
  outcome.state = problem.StateOf(std::move(reference.maps));
  outcome.converged = reference.converged;
  if (dense) TakeLarger(reference.variance, outcome.variance);
  log.renders_before += problem.renders() + reference.evaluations;
  log.Add(outcome.state.misfit, problem.space().count(), 0);
  return outcome;
}

}  // namespace dermap
