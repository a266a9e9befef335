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
#include "fit/free_under_prior.h"
#include "fit/local_scatter.h"
#include "fit/methods.h"
#include "fit/prepare.h"
#include "fit/resample.h"
#include "fit/run_log.h"
#include "fit/size.h"
#include "fit/uncertainty.h"

namespace dermap {
namespace {

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

void FillMisfit(const MethodOutcome& outcome, FitResult& result) {
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
double ExpectedScatter(const MethodOutcome& outcome, const FitResult& result) {
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

FitResult Collect(const PatchProblem& problem, const FitData& data, MethodOutcome outcome,
                  const FitOptions& options, RunLog& log) {
  FitResult result;
  result.bands = data.bands;
  result.conditions = data.conditions;
  result.free_parameters = problem.space().free();
  result.sigma = outcome.variance.empty() ? StandardDeviations(problem, outcome.state)
                                          : SigmaMaps(problem, outcome.variance);
  result.history = std::move(log.history);
  FillMisfit(outcome, result);
  const auto widen = [&](ParameterMaps& sigma) {
    WidenByLocalScatter(problem, outcome.state.misfit, ExpectedScatter(outcome, result), sigma);
  };
  widen(result.sigma);
  if (outcome.telling_variance.empty()) {
    result.flags = FlagsOf(problem, outcome.state, result.sigma);
  } else {
    ParameterMaps telling = SigmaMaps(problem, outcome.telling_variance);
    widen(telling);
    result.flags = FlagsOf(problem, outcome.state, telling);
  }
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
  MethodOutcome outcome;
  switch (options.method) {
    case FitMethod::kFast:
      outcome = RunFast(data, model, make_model, options, log);
      break;
    case FitMethod::kDescent:
      outcome = RunDescent(data, model, make_model, free, options, log);
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
