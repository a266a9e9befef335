// SPDX-License-Identifier: Apache-2.0
// One method at one value of a sweep: how wrong it is, what it says about that, and whether it says enough.
#pragma once

#include <array>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studies/stability_sweeps.h"

namespace dermap {

// Over the judged pixels of all noises; NaN where there is nothing to count.
struct ParameterStability {
  bool free = false;             // in any fit; in the others its sigma claims nothing
  double error = 0.0;            // median |fit - truth|, of pixels that the stack does not mask
  double bound = 0.0;            // what noise alone allows (NoiseBound), median
  double sigma = 0.0;            // median, of pixels without a flag
  double unflagged_error = 0.0;  // median |fit - truth| of them
  double covered = 0.0;          // share of them whose 95 % interval holds the truth
  double decile = 0.0;           // what a tenth of `error`'s pixels exceeds
};

struct StabilityPoint {
  std::string sweep, method;
  double value = 0.0;
  int noises = 0;  // fits, each with its own noise
  std::array<ParameterStability, kParameterCount> parameters{};
  double flagged = 0.0;  // share of the pixels that the stack does not mask
  // The same of the pixels in which noise leaves every parameter less than kSurelyTold as open as what is
  // called not identifiable, by no fewer bands than unknowns; NaN where there are none. In the others that
  // flag is what is asked for.
  double told_flagged = 0.0;
  std::map<std::string, double> flags{};  // share by name
  double chi2 = 0.0;                      // per degree of freedom, mean
  bool converged = true;                  // all of them
  std::string refusal{};                  // the error in place of a fit; else empty
  std::string said{};                     // decisions of the last fit
  double seconds = 0.0;                   // of all fits
  // To be compared with the harmless point (Relate).
  double excess = 0.0;  // error over what noise allows, root mean square over the parameters; of the median
                        // or of the worst tenth of the pixels, whichever is more
  bool silently_wrong = false;
};

// The fit of every noise. A fit that refuses is a result.
StabilityPoint MeasurePoint(const Sweep& sweep, FitMethod method, double value, StabilityBench& bench,
                            int noises, std::uint64_t seed);

// Fills `excess`: errors over those of the harmless point, which grow with what noise allows.
void Relate(const StabilityPoint& harmless, StabilityPoint& point);

// The limits of the issue of silence: below the first, or above the second, intervals lie.
inline constexpr double kCovered = 0.90, kMedianError_sigma = 2.0;
// Of the limit, in sigma. Sigma also holds what all pixels share and that priors are estimates: on honest
// skin the median pixel of `descent` has 1.1 to 1.3 times its bound (these sweeps), single ones more.
inline constexpr double kSurelyTold = 0.6;
inline constexpr double kFlaggedInside = 0.05;  // of the pixels, where a fit is still right

nlohmann::json ToJson(const StabilityPoint& point);
StabilityPoint StabilityPointFromJson(const nlohmann::json& json);

}  // namespace dermap
