// SPDX-License-Identifier: Apache-2.0
// From a reflectance stack to the fit's own data: checked, masked, with a noise for every datum.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/files/stack.h"
#include "common/transport/conditions.h"
#include "fit/options.h"

namespace dermap {

struct FitData {
  std::vector<Band> bands;
  ImagingConditions conditions;
  std::vector<PlaneF> measured;  // reflectance, one plane a band; NaN: missing
  std::vector<PlaneF> sigma;     // one standard deviation; NaN where `measured` is
  // Correlation of the noise of pixels 1, 2, ... apart; empty: independent.
  std::vector<float> noise_correlation_x, noise_correlation_y;
  double shared_error = 0.0;            // relative, of all data of a band: no mean is known better
  double shared_error_allowance = 1.0;  // error bars allow for so many times that
  Plane<std::uint8_t> fitted;           // 1 where a pixel has at least as many data as free parameters
  Plane<std::uint32_t> flags;           // FitFlag bits known before the fit

  int width() const { return measured.empty() ? 0 : measured[0].width(); }
  int height() const { return measured.empty() ? 0 : measured[0].height(); }
  int band_count() const { return static_cast<int>(bands.size()); }
  bool Has(int band, std::size_t pixel) const;
};

// The noise of a stack that states none: 1 % of the reflectance and 0.001, added.
inline constexpr double kDefaultRelativeNoise = 0.01;
inline constexpr double kDefaultNoiseFloor = 0.001;
// Above it a reflectance is no skin's: glare, or a panel's.
inline constexpr double kLargestReflectance = 1.5;
// A reflectance below minus this many standard deviations is not noise around a dark one.
inline constexpr double kNegativeLimit_sigma = 3.0;

// The parameters that the fit frees: those asked for, else [D08 table 1]'s, as many as there are bands.
// Throws InputError where more are asked for than bands could tell. Says in `decisions` what it chose.
std::vector<Parameter> ChooseFreeParameters(const std::vector<Parameter>& asked, int band_count,
                                            std::vector<std::string>& decisions);

// Throws InputError for a stack that cannot be fitted: no pixel size, planes of different shapes, no valid
// datum.
FitData PrepareStack(const ReflectanceStack& stack, const FitOptions& options, int free_count,
                     std::vector<std::string>& decisions);

// What was asked for, else the stack's, else kSharedError.
double SharedErrorOf(const ReflectanceStack& stack, const FitOptions& options);

// Marks the pixels that have at least `free_count` data in `fitted`, and flags the others kFlagSaturated.
void MarkFitted(FitData& data, int free_count);

}  // namespace dermap
