// SPDX-License-Identifier: Apache-2.0
// Fits counted.
#include "studies/stability_point.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "fit/fit.h"
#include "studies/noise_bound.h"
#include "studies/point_journal.h"

namespace dermap {
namespace {

constexpr double kLeastError = 1e-4;  // of the range
constexpr double kTwoSided95 = 1.959964;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// What the fits of one point add up to.
struct Tally {
  struct PerParameter {
    std::vector<double> errors, unflagged_errors, sigmas, bounds;
    double covered = 0.0;
    bool free = false;  // in any
  };
  std::array<PerParameter, kParameterCount> parameters;
  double pixels = 0.0, flagged = 0.0, told = 0.0, told_flagged = 0.0;
  std::array<double, kFitFlagNames.size()> flags{};
};

// Fewer bands than unknowns cannot tell them: then what is fixed decides, and that may be off.
bool IsSurelyTold(const ParameterVector& bound, int bands) {
  if (bands < kUnknownCount) return false;
  for (int k = 0; k < kParameterCount; ++k) {
    const double of_range = (kParameters[k].upper - kParameters[k].lower) / std::sqrt(12.0);
    if (bound[k] > kSurelyTold * kIdentifiable * of_range) return false;
  }
  return true;
}

void CountFlags(std::uint32_t flags, bool told, Tally& tally) {
  tally.pixels += 1.0;
  tally.flagged += flags != 0;
  tally.told += told;
  tally.told_flagged += told && flags != 0;
  for (std::size_t bit = 0; bit < tally.flags.size(); ++bit) tally.flags[bit] += flags >> bit & 1u;
}

// NaN where there is no datum.
std::vector<PlaneF> NoiseOfData(const ReflectanceStack& stack) {
  std::vector<PlaneF> noise = stack.sigma;
  for (std::size_t b = 0; b < noise.size(); ++b)
    for (std::size_t i = 0; i < noise[b].size(); ++i)
      if (std::isnan(stack.reflectance[b].data()[i]))
        noise[b].data()[i] = std::numeric_limits<float>::quiet_NaN();
  return noise;
}

void Count(const StabilityCase& made, const ForwardModel& model, const std::vector<PlaneF>& noise,
           const FitResult& fit, Tally& tally) {
  std::array<bool, kParameterCount> free;
  for (int k = 0; k < kParameterCount; ++k) {
    free[k] =
        std::count(fit.free_parameters.begin(), fit.free_parameters.end(), static_cast<Parameter>(k)) > 0;
    tally.parameters[k].free |= free[k];
  }
  for (std::size_t i = 0; i < fit.flags.size(); ++i) {
    const std::uint32_t flags = fit.flags.data()[i];
    if ((!made.judged.empty() && !made.judged[i]) || flags & kFlagSaturated) continue;
    const ParameterVector bound = PixelNoiseBound(model, made.truth, noise, i);
    CountFlags(flags, IsSurelyTold(bound, model.band_count()), tally);
    for (int k = 0; k < kParameterCount; ++k) {
      const double error = std::abs(double(fit.maps.planes[k].data()[i]) - made.truth.planes[k].data()[i]);
      tally.parameters[k].errors.push_back(error);
      if (flags != 0 || !free[k]) continue;
      const double sigma = fit.sigma.planes[k].data()[i];
      tally.parameters[k].sigmas.push_back(sigma);
      tally.parameters[k].unflagged_errors.push_back(error);
      tally.parameters[k].covered += error <= kTwoSided95 * sigma;
    }
  }
}

void Conclude(const Tally& tally, StabilityPoint& point) {
  point.flagged = tally.pixels > 0.0 ? tally.flagged / tally.pixels : kNaN;
  point.told_flagged = tally.told > 0.0 ? tally.told_flagged / tally.told : kNaN;
  for (std::size_t bit = 0; bit < tally.flags.size(); ++bit)
    if (tally.flags[bit] > 0.0) point.flags[kFitFlagNames[bit]] = tally.flags[bit] / tally.pixels;
  for (int k = 0; k < kParameterCount; ++k) {
    const Tally::PerParameter& from = tally.parameters[k];
    ParameterStability& p = point.parameters[k];
    p.free = from.free;
    p.error = MedianOrNaN(from.errors);
    p.decile = QuantileOrNaN(from.errors, 0.9);
    p.bound = MedianOrNaN(from.bounds);
    p.sigma = MedianOrNaN(from.sigmas);
    p.unflagged_error = MedianOrNaN(from.unflagged_errors);
    p.covered = from.sigmas.empty() ? kNaN : from.covered / static_cast<double>(from.sigmas.size());
    if (p.free && (p.covered < kCovered || p.unflagged_error > kMedianError_sigma * p.sigma))
      point.silently_wrong = true;
  }
}

}  // namespace

StabilityPoint MeasurePoint(const Sweep& sweep, FitMethod method, double value, StabilityBench& bench,
                            int noises, std::uint64_t seed) {
  StabilityPoint point{.sweep = sweep.name, .method = std::string(NameOf(method)), .value = value};
  point.noises = noises;
  Tally tally;
  for (int n = 0; n < noises; ++n) {
    StabilityCase made = sweep.make(value, seed + n);
    const ForwardModel model = bench.ModelFor(made.stack, made.tissue);
    const std::vector<PlaneF> noise = NoiseOfData(made.stack);
    const ParameterVector bound = NoiseBound(model, made.truth, noise);
    for (int k = 0; k < kParameterCount; ++k) tally.parameters[k].bounds.push_back(bound[k]);
    made.options.method = method;
    made.options.time_budget_s = 1e6;
    made.options.size = std::max(made.stack.width(), made.stack.height());
    try {
      const FitResult fit = FitStack(made.stack, made.options, bench.chromophores());
      Count(made, model, noise, fit, tally);
      point.converged &= fit.converged;
      point.chi2 += fit.chi2 / noises;
      point.seconds += fit.seconds;
      point.said = fmt::format("{}", fmt::join(fit.decisions, " "));
    } catch (const InputError& error) {
      point.refusal = error.what();
    }
  }
  Conclude(tally, point);
  return point;
}

void Relate(const StabilityPoint& harmless, StabilityPoint& point) {
  const auto excess = [&](double ParameterStability::*error, double over_sigma) {
    double sum = 0.0;
    for (int k = 0; k < kParameterCount; ++k) {
      const ParameterStability& from = harmless.parameters[k];
      const ParameterStability& p = point.parameters[k];
      // A patch may be right by chance; half of what sigma says is what an honest fit may expect.
      // A map of one value that happens to be the truth has no error at all: then so much of the range
      // counts.
      const double least = kLeastError * (kParameters[k].upper - kParameters[k].lower);
      // Sigma allows for errors of calibration that these data lack: at most so much of it is noise.
      const double of_noise = from.sigma / kUnstatedAllowance;
      const double expected = std::max({from.*error, 0.5 * over_sigma * of_noise, least});
      const double ratio = p.*error / (expected * std::max(p.bound / from.bound, 1e-6));
      sum += ratio * ratio / kParameterCount;
    }
    return std::sqrt(sum);
  };
  point.excess = std::max(excess(&ParameterStability::error, kMedianOverSigma),
                          excess(&ParameterStability::decile, kDecileOverSigma));
}

nlohmann::json ToJson(const StabilityPoint& point) {
  nlohmann::json parameters;
  for (int k = 0; k < kParameterCount; ++k) {
    const ParameterStability& p = point.parameters[k];
    parameters[std::string(kParameters[k].name)] = {
        {"free", p.free},         {"error", p.error},
        {"noise_bound", p.bound}, {"unflagged_error", p.unflagged_error},
        {"sigma", p.sigma},       {"covered", p.covered},
        {"decile", p.decile}};
  }
  return {{"sweep", point.sweep},
          {"method", point.method},
          {"value", point.value},
          {"noises", point.noises},
          {"parameters", parameters},
          {"flagged", point.flagged},
          {"told_flagged", point.told_flagged},
          {"flags", point.flags},
          {"chi2", point.chi2},
          {"converged", point.converged},
          {"refusal", point.refusal},
          {"said", point.said},
          {"seconds", point.seconds},
          {"excess", point.excess},
          {"silently_wrong", point.silently_wrong}};
}

StabilityPoint StabilityPointFromJson(const nlohmann::json& json) {
  StabilityPoint point;
  point.sweep = json.at("sweep");
  point.method = json.at("method");
  point.value = json.at("value");
  point.noises = json.at("noises");
  for (int k = 0; k < kParameterCount; ++k) {
    const nlohmann::json& p = json.at("parameters").at(std::string(kParameters[k].name));
    point.parameters[k] = {p.at("free"),
                           NumberOrNaN(p.at("error")),
                           NumberOrNaN(p.at("noise_bound")),
                           NumberOrNaN(p.at("sigma")),
                           NumberOrNaN(p.at("unflagged_error")),
                           NumberOrNaN(p.at("covered")),
                           NumberOrNaN(p.at("decile"))};
  }
  point.flagged = NumberOrNaN(json.at("flagged"));
  point.told_flagged = NumberOrNaN(json.at("told_flagged"));
  point.flags = json.at("flags").get<std::map<std::string, double>>();
  point.chi2 = NumberOrNaN(json.at("chi2"));
  point.converged = json.at("converged");
  point.refusal = json.at("refusal");
  point.said = json.at("said");
  point.seconds = NumberOrNaN(json.at("seconds"));
  point.excess = NumberOrNaN(json.at("excess"));
  point.silently_wrong = json.at("silently_wrong");
  return point;
}

}  // namespace dermap
