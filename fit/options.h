// SPDX-License-Identifier: Apache-2.0
// What a caller may choose about a fit, and how the command line's words become these choices.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/tissue/parameters.h"
#include "common/tissue/tissue.h"
#include "common/transport/forward_model.h"
#include "fit/learnt_prior.h"
#include "fit/resume.h"

namespace dermap {

enum class FitMethod {
  kFast,     // coarse to fine, damped Gauss-Newton a pixel with the full render as residual
  kDescent,  // simultaneous descent in all pixels from forward differences [D08 6.3]
  kCeres,    // the reference: the minimum of the fast fit's objective, by Ceres
};

// Average skin as in [D08 6.3] | closed-form inversion a pixel | a random point of table 1, the same in all
// pixels.
enum class StartPoint { kAverage, kLocal, kRandom };

// How descent turns forward differences into a step.
enum class DescentMetric {
  kPlain,      // along the negative gradient, as in [D08 6.3]
  kCurvature,  // the gradient preconditioned by the pixel's own normal matrix, from the same differences
};

// Asked between steps, from the fit's own thread: true ends the fit where it stands.
using StopFunction = std::function<bool()>;

// Relative: how well calibration and tables know a band (exact_judged_test, `dermap study calibration`).
inline constexpr double kSharedError = 1e-3;
// Error bars allow for so many times that where nobody has said how well a band is known: what is expected
// decides what the fit makes of the data, and a single session may be twice as far off.
inline constexpr double kUnstatedAllowance = 2.0;

struct FitOptions {
  FitMethod method = FitMethod::kFast;
  DescentMetric metric = DescentMetric::kCurvature;
  std::string profiles = "exact";
  ForwardOptions forward;
  double tolerance = 0.0;  // of a render, relative (ForwardOptions::tolerance); 0: a tenth of the noise
  std::optional<double> shared_error;      // relative; nothing: the stack's own, or kSharedError
  std::vector<Parameter> free_parameters;  // empty ("auto"): fast weighs the evidence, descent counts bands
  ParameterVector fixed_values = AverageSkin();  // of what is not free; also where kAverage starts
  std::optional<LearntPrior> prior;              // what earlier fits found; fast only
  StartPoint start =
      StartPoint::kAverage;  // of descent and, if random, ceres: fast starts from the local inversion
  int size = 0;              // pixels along the longer side; 0: the largest that the time budget allows
  double time_budget_s = 60.0;
  int max_iterations = 400;  // [D08 6.3]
  double stop_chi2 =
      1.02;  // squared residual over noise, per degree of freedom (Misfit); 0: never stop on it
  // Scaled units. Small against curvature, large against the rounding of a float render (3e-8): of dermal
  // blood at its bound, the weakest direction tried, a step of 1e-2 gives the derivative within 0.2 %, 1e-3
  // within 1 to 4 %, 5e-2 within 3 %.
  double difference_step = 5e-3;
  int threads = 0;                      // 0: all cores
  std::optional<double> pixel_size_mm;  // overrides the stack's
  TissueConfig tissue;
  StopFunction stop;                    // may be empty
  std::optional<UnfinishedFit> resume;  // goes on from it
  std::uint64_t seed = 1;               // of kRandom
};

// Each throws InputError that lists the known names.
FitMethod FitMethodFromName(std::string_view name);          // fast, descent, ceres
DescentMetric DescentMetricFromName(std::string_view name);  // curvature, plain
StartPoint StartPointFromName(std::string_view name);        // average, local, random
std::string_view NameOf(FitMethod method);
std::string_view NameOf(DescentMetric metric);
std::string_view NameOf(StartPoint start);

// "auto" (empty list) or names of table 1 separated by commas, each once.
std::vector<Parameter> FreeParametersFromText(std::string_view text);

}  // namespace dermap
