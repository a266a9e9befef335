// SPDX-License-Identifier: Apache-2.0
// From stack to result: prepare, choose a size, run the method, count the errors.
#include "fit/fit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "common/core/parallel.h"
#include "common/optics/profile_source.h"
#include "fit/ceres_reference.h"
#include "fit/descent.h"
#include "fit/fast.h"
#include "fit/free_under_prior.h"
#include "fit/local_scatter.h"
#include "fit/prepare.h"
#include "fit/resample.h"
#include "fit/run_log.h"
#include "fit/size.h"
#include "fit/start_maps.h"
#include "fit/uncertainty.h"

namespace dermap {
namespace {

constexpr double kLoudScatter = 1.2;  // of residuals over noise, variances: above it the fit says so

// What a method leaves behind.
struct Outcome {
  std::vector<Parameter> free;
  FitState state;
  bool converged = false;
  std::optional<double> adapted_parameters;  // where it was measured
  std::vector<PlaneF> variance;        // of each free parameter, scaled units; empty: from single pixels
  std::vector<PlaneF> noise_variance;  // the same by noise alone, where that is much less
  bool grossly_told = false;           // what was told is far from what the data speak for
  double scatter = 1.0;                // of residuals over noise that `variance` holds already
  std::vector<Candidate> candidates;
};

template <class... Args>
std::string Format(const char* format, Args... args) {
  char text[360];
  std::snprintf(text, sizeof text, format, args...);
  return text;
}

// Seconds of one full render, of the data at 64 pixels or at their own size.
double SecondsPerPixel(const FitData& data, const ModelMaker& make_model, const ParameterVector& start) {
  const FitData small = ReduceData(data, 64, 1);
  const ForwardModel model = make_model(small.conditions);
  const ParameterMaps maps(small.width(), small.height(), start);
  model.Render(maps);  // fills caches
  const auto begin = std::chrono::steady_clock::now();
  model.Render(maps);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return seconds / static_cast<double>(small.fitted.size());
}

int ChooseSize(const FitData& data, const FitOptions& options, const ModelMaker& make_model, int free_count,
               RunLog& log) {
  const int longer = std::max(data.width(), data.height()), shorter = std::min(data.width(), data.height());
  if (options.resume) return SizeToResume(*options.resume, options, longer);
  if (options.size > 0) {
    const int size = std::min(options.size, longer);
    log.Decide(Format("The fit ran at %d pixels along the longer side, as asked for (the stack has %d).",
                      size, longer));
    return size;
  }
  if (longer <= 32) return longer;
  const double renders = ExpectedRenders(options, free_count);
  return LargestAffordableSize(longer, static_cast<double>(shorter) / longer,
                               SecondsPerPixel(data, make_model, options.fixed_values), renders,
                               options.time_budget_s, log.decisions);
}

Outcome RunDescent(const FitData& data, const ForwardModel& model, const std::vector<Parameter>& free,
                   const FitOptions& options, RunLog& log) {
  PatchProblem problem(data, model, ParameterSpace(free));
  ParameterMaps start =
      StartMaps(problem, PointOf(options.fixed_values, model.tissue().junction_absorbance), options, log);
  DescentOutcome descent = Descend(problem, std::move(start), options, log);
  log.renders_before += problem.renders();
  log.Decide(Format(
      "Degrees of freedom: data less %.1f parameters a fitted pixel, the share of %d that simulated fits "
      "adapted to.",
      descent.state.misfit.adapted_share * problem.space().count(), problem.space().count()));
  Outcome outcome;
  outcome.free = problem.space().free();
  outcome.state = std::move(descent.state);
  outcome.converged = descent.converged;
  return outcome;
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

Outcome OutcomeOf(FastOutcome fast) {
  Outcome outcome;
  outcome.free = std::move(fast.free);
  outcome.state = std::move(fast.state);
  outcome.converged = fast.converged;
  outcome.adapted_parameters = fast.adapted_parameters;
  outcome.variance = std::move(fast.variance);
  outcome.noise_variance = std::move(fast.noise_variance);
  outcome.scatter = fast.detail.scatter[0];
  outcome.grossly_told = std::any_of(fast.doubts.all().begin(), fast.doubts.all().end(),
                                     [](const Doubt& doubt) { return doubt.IsGross(); });
  outcome.candidates = std::move(fast.candidates);
  return outcome;
}

Outcome RunFast(FitData& data, const ForwardModel& model, const ModelMaker& make_model,
                const FitOptions& options, RunLog& log) {
  if (options.start == StartPoint::kRandom)
    log.Decide("The fast fit always starts from the closed-form inversion: --start random was not followed.");
  FastOutcome fast = FitCoarseToFine(data, model, AskedFor(options), make_model, options, log);
  if (!fast.candidates.empty()) SayWhatIsFree(fast, data.band_count(), log);
  log.Decide(Format("Degrees of freedom: the data decide %.2f parameters a pixel; the rest is prior.",
                    fast.adapted_parameters / static_cast<double>(fast.state.misfit.chi2_map.size())));
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
  return OutcomeOf(std::move(fast));
}

// The fast fit's variances hold also what all pixels share and what it was told; the reference's the lateral
// coupling to the letter.
void TakeLarger(const std::vector<PlaneF>& other, std::vector<PlaneF>& variance) {
  for (std::size_t j = 0; j < variance.size(); ++j)
    for (std::size_t i = 0; i < variance[j].size(); ++i)
      variance[j].data()[i] = std::max(variance[j].data()[i], other[j].data()[i]);
}

// The reference takes over what the fast fit found to be free, and how much detail there is. On small patches
// it starts where the fast fit starts, from the closed-form inversion; on others, where gradients alone lead,
// from the fast fit's maps, whose objective it can only lower.
Outcome RunReference(FitData& data, const ForwardModel& model, const ModelMaker& make_model,
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
  Outcome outcome = OutcomeOf(std::move(fast));
  outcome.state = problem.StateOf(std::move(reference.maps));
  outcome.converged = reference.converged;
  if (dense) TakeLarger(reference.variance, outcome.variance);
  log.renders_before += problem.renders() + reference.evaluations;
  log.Add(outcome.state.misfit, problem.space().count(), 0);
  return outcome;
}

void FillMisfit(const Outcome& outcome, FitResult& result) {
  const Misfit& misfit = outcome.state.misfit;
  result.rms_residual = misfit.rms;
  result.rms_residual_per_band = misfit.rms_per_band;
  result.data_count = misfit.data_count;
  result.chi2_per_datum = misfit.chi2 / static_cast<double>(std::max<std::size_t>(misfit.data_count, 1));
  const double data_count = static_cast<double>(misfit.data_count);
  const double expected = misfit.DegreesOfFreedom(static_cast<int>(result.free_parameters.size()));
  result.degrees_of_freedom =
      outcome.adapted_parameters ? std::max(data_count - *outcome.adapted_parameters, 1.0) : expected;
  result.chi2 = misfit.chi2 / result.degrees_of_freedom;
  const double per_dof = data_count / result.degrees_of_freedom;
  for (FitIteration& step : result.history) step.chi2 *= expected / result.degrees_of_freedom;
  result.chi2_map = PlaneF(misfit.chi2_map.width(), misfit.chi2_map.height());
  for (std::size_t i = 0; i < result.chi2_map.size(); ++i)
    result.chi2_map.data()[i] =
        static_cast<float>(misfit.chi2_map.data()[i] * per_dof / static_cast<double>(result.bands.size()));
}

// chi2 a datum where residuals are as everywhere.
double ExpectedScatter(const Outcome& outcome, const FitResult& result) {
  return outcome.scatter * result.degrees_of_freedom /
         static_cast<double>(std::max<std::size_t>(result.data_count, 1));
}

double UnexplainedShare(const FitData& data, const Plane<std::uint32_t>& flags) {
  double fitted = 0.0, unexplained = 0.0;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (!data.fitted.data()[i]) continue;
    fitted += 1.0;
    unexplained += (flags.data()[i] & (kFlagNotConverged | kFlagUnexplained)) != 0;
  }
  return fitted > 0.0 ? unexplained / fitted : 0.0;
}

// The largest tolerance and the smallest that a tenth of the noise is taken for.
constexpr double kLargestTolerance = 1e-2, kSmallestTolerance = 2e-5;
constexpr double kQuietTolerance = 0.2;  // of the noise: a render's error above it is no longer hidden in it
constexpr double kDescentTolerance = 1e-4;

double MedianRelativeNoise(const FitData& data) {
  std::vector<double> noise;
  for (int b = 0; b < data.band_count(); ++b)
    for (std::size_t i = 0; i < data.fitted.size(); i += 7)
      if (data.fitted.data()[i] && data.Has(b, i))
        noise.push_back(data.sigma[b].data()[i] /
                        std::max(data.measured[b].data()[i], data.sigma[b].data()[i]));
  if (noise.empty()) return 10.0 * ForwardOptions{}.tolerance;
  std::nth_element(noise.begin(), noise.begin() + static_cast<std::ptrdiff_t>(noise.size() / 2), noise.end());
  return noise[noise.size() / 2];
}

// How exact renders must be: a tenth of the noise.
ForwardOptions ForwardOptionsFor(const FitData& data, const FitOptions& options, RunLog& log) {
  ForwardOptions forward = options.forward;
  if (options.tolerance > 0.0) {
    forward.tolerance = options.tolerance;
  } else if (options.method != FitMethod::kFast) {
    // What is left out must not jump by more than a forward difference or a line search's step changes.
    forward.tolerance = std::clamp(0.1 * MedianRelativeNoise(data), kSmallestTolerance, kDescentTolerance);
  } else {
    forward.tolerance = std::clamp(0.1 * MedianRelativeNoise(data), kSmallestTolerance, kLargestTolerance);
    log.Decide(
        Format("Renders are exact to %.2g of the reflectance, a tenth of the noise.", forward.tolerance));
  }
  return forward;
}

FitResult Collect(const PatchProblem& problem, const FitData& data, Outcome outcome,
                  const FitOptions& options, RunLog& log) {
  FitResult result;
  result.bands = data.bands;
  result.conditions = data.conditions;
  result.free_parameters = problem.space().free();
  result.sigma = outcome.variance.empty() ? StandardDeviations(problem, outcome.state)
                                          : SigmaMaps(problem, outcome.variance);
  result.history = std::move(log.history);
  FillMisfit(outcome, result);
  WidenByLocalScatter(problem, outcome.state.misfit, ExpectedScatter(outcome, result), result.sigma);
  result.flags = FlagsOf(problem, outcome.state, result.sigma);
  FlagUnexplained(problem, outcome.noise_variance, result.sigma, result.flags);
  if (outcome.grossly_told) FlagAll(problem, kFlagUnexplained, result.flags);
  result.unexplained_share = UnexplainedShare(data, result.flags);
  if (!result.Explained())
    log.Decide(Format("The model does not explain %.0f %% of the pixels: their maps are not to be trusted.",
                      100.0 * result.unexplained_share));
  result.candidates = std::move(outcome.candidates);
  result.measured = data.measured;
  result.noise = data.sigma;
  result.residual = Residual(data, outcome.state.predicted);
  result.tolerance = problem.model().options().tolerance;
  if (problem.model().options().engine == Engine::kLowRank)
    problem.model().Render(outcome.state.maps, {}, &result.forward);
  result.maps = std::move(outcome.state.maps);
  result.predicted = std::move(outcome.state.predicted);
  result.converged = outcome.converged;
  result.renders = log.renders_before;
  result.method = NameOf(options.method);
  result.profiles = options.profiles;
  result.engine = EngineName(options.forward.engine);
  result.decisions = std::move(log.decisions);
  result.seconds = log.Seconds();
  result.finished = result.converged || !log.Stopped();
  if (!result.finished)
    result.decisions.emplace_back(
        "The fit was interrupted: maps and error bars are as far as it had come (--resume goes on).");
  return result;
}

}  // namespace

FitResult FitStack(const ReflectanceStack& stack, const FitOptions& options, const Chromophores& chromophores,
                   const ProgressFunction& progress) {
  const ThreadLimit limit(options.threads);
  RunLog log(progress, options.stop);
  Validate(options.tissue);
  // The evidence chooses later, or the number of bands now.
  const bool by_evidence = options.method != FitMethod::kDescent && AskedFor(options).empty();
  std::vector<std::string> said;
  const int bands = static_cast<int>(stack.bands.size());
  const std::vector<Parameter> free = FreeFor(options, bands, by_evidence ? said : log.decisions);
  const int fewest = std::min({static_cast<int>(free.size()), kParameterCount, bands});  // data of a pixel
  FitData data = PrepareStack(stack, options, fewest, log.decisions);
  const SettingList settings = SettingsOf(stack, options);
  if (options.resume) {
    CheckSameSettings(*options.resume, settings);
    log.Decide(Format("Goes on from the maps in %s, which took %.1f s and %d renders.",
                      options.resume->directory.c_str(), options.resume->seconds, options.resume->renders));
  }
  const auto source = MakeProfileSource(options.profiles);
  if (options.profiles != "exact")  // measured against Monte Carlo: common/optics/README.md
    log.Decide(
        "The multipole's reflectance is 8 % too low to 40 % too high, which a small residual does not show: "
        "on real "
        "skin it finds about half too much melanin. Use --profiles exact there (docs/optics.md).");
  const ForwardOptions forward = ForwardOptionsFor(data, options, log);
  if (forward.tolerance > kQuietTolerance * MedianRelativeNoise(data))
    AddRelativeError(data, forward.tolerance);
  const ForwardModel tables(chromophores, *source, options.tissue, data.bands, data.conditions, forward);
  const ModelMaker make_model = [&](const ImagingConditions& conditions) { return tables.With(conditions); };
  const int full_width = data.width();
  data = ReduceData(data, ChooseSize(data, options, make_model, fewest, log), fewest);
  if (data.width() < full_width) {
    AddRelativeError(data, kReductionError);
    log.Decide(
        Format("Sigma was widened by %g of the reflectance for the averaging of areas.", kReductionError));
  }
  const ForwardModel model = make_model(data.conditions);
  Outcome outcome;
  switch (options.method) {
    case FitMethod::kFast:
      outcome = RunFast(data, model, make_model, options, log);
      break;
    case FitMethod::kDescent:
      outcome = RunDescent(data, model, free, options, log);
      break;
    case FitMethod::kCeres:
      outcome = RunReference(data, model, make_model, options, log);
      break;
  }
  const PatchProblem problem(data, model, ParameterSpace(outcome.free));
  FitResult result = Collect(problem, data, std::move(outcome), options, log);
  result.settings = settings;
  return result;
}

}  // namespace dermap
