// SPDX-License-Identifier: Apache-2.0
// Checks and masks of a stack, and the default noise.
#include "fit/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "common/core/error.h"
#include "fit/copied_bands.h"
#include "fit/fit_result.h"

namespace dermap {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kSmallestSigma = 1e-6;  // a stack that claims less would overflow chi2

// In this order parameters are given up where there are too few bands: those that data determine least first.
constexpr std::array<Parameter, kParameterCount> kDropOrder{
    Parameter::kC_bc, Parameter::kC_he, Parameter::kBeta_m, Parameter::kC_hd, Parameter::kC_m};

std::string NameList(const std::vector<Parameter>& parameters) {
  std::string names;
  for (Parameter p : parameters)
    names += (names.empty() ? "" : ", ") + std::string(kParameters[static_cast<int>(p)].name);
  return names;
}

struct MaskCounts {
  std::size_t missing = 0, too_bright = 0, negative = 0, without_sigma = 0;
};

double DefaultSigma(double reflectance) {
  return kDefaultRelativeNoise * std::abs(reflectance) + kDefaultNoiseFloor;
}

// One datum: masks it where it cannot be reflectance.
void PrepareDatum(const ReflectanceStack& stack, int band, std::size_t pixel, FitData& data,
                  MaskCounts& counts) {
  float& measured = data.measured[band].data()[pixel];
  float& sigma = data.sigma[band].data()[pixel];
  const float value = stack.reflectance[band].data()[pixel];
  const bool valid = stack.valid.empty() || stack.valid.data()[pixel] >= 0.5f;
  measured = sigma = kNaN;
  if (!valid || !std::isfinite(value)) {
    ++counts.missing;
    return;
  }
  double noise = stack.sigma.empty() ? kNaN : stack.sigma[band].data()[pixel];
  if (!std::isfinite(noise) || noise <= 0.0) {
    noise = DefaultSigma(value);
    if (!stack.sigma.empty()) ++counts.without_sigma;
  }
  noise = std::max(noise, kSmallestSigma);
  if (value > kLargestReflectance || value < -kNegativeLimit_sigma * noise) {
    ++(value > kLargestReflectance ? counts.too_bright : counts.negative);
    data.flags.data()[pixel] |= kFlagOutsideValidity;
    return;
  }
  measured = value;
  sigma = static_cast<float>(noise);
}

void Record(const MaskCounts& counts, std::size_t total, bool has_sigma,
            std::vector<std::string>& decisions) {
  char text[240];
  const auto say = [&](const char* format, std::size_t count) {
    if (count == 0) return;
    std::snprintf(text, sizeof text, format, count, total);
    decisions.emplace_back(text);
  };
  say("%zu of %zu data are missing in the stack and were left out.", counts.missing);
  say("%zu of %zu data are above a reflectance of 1.5 and were left out.", counts.too_bright);
  say("%zu of %zu data are negative by more than three standard deviations and were left out.",
      counts.negative);
  say("%zu of %zu data have no usable sigma and were given 1 %% of the reflectance plus 0.001.",
      counts.without_sigma);
  if (!has_sigma)
    decisions.emplace_back(
        "The stack states no noise: 1 % of the reflectance plus 0.001 was taken as one standard deviation; "
        "the error "
        "bars are only as good as that.");
}

void CheckShape(const ReflectanceStack& stack) {
  if (stack.bands.empty() || stack.reflectance.size() != stack.bands.size() || stack.reflectance[0].empty())
    throw InputError("The stack has no pixels or no bands; a fit needs at least one band of one pixel.");
  const auto same = [&](const PlaneF& plane) { return plane.SameShape(stack.reflectance[0]); };
  if (!std::all_of(stack.reflectance.begin(), stack.reflectance.end(), same) ||
      !std::all_of(stack.sigma.begin(), stack.sigma.end(), same) ||
      (!stack.sigma.empty() && stack.sigma.size() != stack.bands.size()) ||
      (!stack.valid.empty() && !same(stack.valid)))
    throw InputError(
        "The planes of the stack differ in shape or number; every band needs one plane of one size.");
}

ImagingConditions ConditionsOf(const ReflectanceStack& stack, const FitOptions& options) {
  const std::optional<double> pixel = options.pixel_size_mm ? options.pixel_size_mm : stack.pixel_size_mm;
  if (!pixel)
    throw InputError(
        "The stack has no dermap:pixelSizeMm, and light spreads in mm, not in pixels; give --pixel-size-mm, "
        "the side "
        "of a pixel on the skin.");
  if (!(*pixel > 0.0) || !std::isfinite(*pixel))
    throw InputError("The pixel size is " + std::to_string(*pixel) +
                     " mm, but must be above 0; give --pixel-size-mm, the side of a pixel on the skin.");
  return {*pixel, stack.illumination, stack.tape, stack.geometry};
}

}  // namespace

bool FitData::Has(int band, std::size_t pixel) const {
  return std::isfinite(measured[band].data()[pixel]);
}

std::vector<Parameter> ChooseFreeParameters(const std::vector<Parameter>& asked, int band_count,
                                            std::vector<std::string>& decisions) {
  if (!asked.empty()) {
    if (static_cast<int>(asked.size()) > band_count)
      throw InputError("The stack has " + std::to_string(band_count) + " band(s), which cannot tell " +
                       std::to_string(asked.size()) + " free parameters (" + NameList(asked) +
                       ") apart; free at most as many parameters as there are bands, or use --free auto.");
    return asked;
  }
  std::vector<Parameter> free;
  for (int i = 0; i < kParameterCount; ++i) free.push_back(static_cast<Parameter>(i));
  std::vector<Parameter> dropped;
  for (Parameter p : kDropOrder) {
    if (static_cast<int>(free.size()) <= band_count) break;
    free.erase(std::find(free.begin(), free.end(), p));
    dropped.push_back(p);
  }
  if (dropped.empty())
    decisions.push_back("All five parameters are free: there are " + std::to_string(band_count) + " bands.");
  else
    decisions.push_back("Only " + NameList(free) + " is free, since " + std::to_string(band_count) +
                        " band(s) cannot tell more apart; fixed at average skin: " + NameList(dropped) + ".");
  return free;
}

double SharedErrorOf(const ReflectanceStack& stack, const FitOptions& options) {
  return options.shared_error.value_or(stack.shared_error.value_or(kSharedError));
}

FitData PrepareStack(const ReflectanceStack& stack, const FitOptions& options, int free_count,
                     std::vector<std::string>& decisions) {
  CheckShape(stack);
  FitData data;
  data.bands = stack.bands;
  data.conditions = ConditionsOf(stack, options);
  data.shared_error = SharedErrorOf(stack, options);
  if (!options.shared_error && !stack.shared_error) data.shared_error_allowance = kUnstatedAllowance;
  if (!options.shared_error && stack.shared_error)
    decisions.push_back(
        fmt::format("All pixels of a band share an error of {:g} of its reflectance, as the stack says.",
                    *stack.shared_error));
  data.noise_correlation_x = stack.noise_correlation_x;
  data.noise_correlation_y = stack.noise_correlation_y;
  data.measured.assign(stack.bands.size(), PlaneF(stack.width(), stack.height()));
  data.sigma = data.measured;
  data.flags = Plane<std::uint32_t>(stack.width(), stack.height());
  MaskCounts counts;
  const std::size_t pixels = data.measured[0].size();
  for (int b = 0; b < data.band_count(); ++b)
    for (std::size_t i = 0; i < pixels; ++i) PrepareDatum(stack, b, i, data, counts);
  LeaveOutCopies(data, decisions);
  const std::size_t total = pixels * stack.bands.size();
  if (counts.missing + counts.too_bright + counts.negative == total)
    throw InputError(
        "The stack has no usable datum: every value is missing, masked as invalid, negative or above 1.5; "
        "reflectance "
        "is expected as a fraction, 0 to 1.");
  Record(counts, total, !stack.sigma.empty(), decisions);
  MarkFitted(data, free_count);
  if (std::none_of(data.fitted.values().begin(), data.fitted.values().end(), [](auto f) { return f != 0; }))
    throw InputError("No pixel of the stack has the " + std::to_string(free_count) +
                     " valid bands that as many free parameters need; free fewer parameters (--free).");
  return data;
}

void MarkFitted(FitData& data, int free_count) {
  data.fitted = Plane<std::uint8_t>(data.width(), data.height());
  for (std::size_t i = 0; i < data.fitted.size(); ++i) {
    int count = 0;
    for (int b = 0; b < data.band_count(); ++b) count += data.Has(b, i);
    data.fitted.data()[i] = count >= std::max(free_count, 1);
    if (!data.fitted.data()[i]) data.flags.data()[i] |= kFlagSaturated;
  }
}

}  // namespace dermap
