// SPDX-License-Identifier: Apache-2.0
// A band whose gain is wrong shows in the patch's mean: the others agree on a skin that this one denies.
#pragma once

#include <optional>

#include "fit/detail_model.h"
#include "fit/octave_levels.h"

namespace dermap {

// Calibration and tables are good to some parts in a thousand.
inline constexpr double kLoudGain = 0.008;
inline constexpr double kQuietGain = 1e-3;  // of a band that was found already

struct SuspectBand {
  int band = 0;
  double gain_error = 0.0;    // measured over what the other bands make of it, less 1
  double log_evidence = 0.0;  // half of the misfit that goes with it
};

// The band without which the mean spectrum fits: leaving it out must take away most of the misfit of the
// mean, and it must be off by more than `least`. Needs two bands more than free parameters. `levels` are
// those of a fit that rests (fit/octave_levels.h).
std::optional<SuspectBand> FindSuspectBand(const PatchProblem& problem,
                                           const std::vector<OctaveLevel>& levels, const DetailView& detail,
                                           const SkinPoint& fixed, double least = kLoudGain);

// Of chi2, what bands' gains alone would explain: a gross one leaves the others off as well.
double ShareOfGains(const FitData& data, const FitState& state);
// Measured over predicted, sums over the pixels, less 1.
double GainError(const FitData& data, int band, const PlaneF& predicted);

}  // namespace dermap
