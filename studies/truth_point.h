// SPDX-License-Identifier: Apache-2.0
// Fits of one scene with one choice of what is free, held to what is known of the scene.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/tissue/parameters.h"

namespace dermap {

// Intervals whose coverage is counted: their share of a Gaussian, and their half length in sigma.
struct Interval {
  double share, half_length;
};
inline constexpr std::array<Interval, 5> kIntervals{
    {{0.38, 0.4959}, {0.68, 0.9945}, {0.87, 1.5141}, {0.95, 1.9600}, {0.99, 2.5758}}};
inline constexpr std::size_t k68 = 1, k95 = 3;

// Over all draws of the noise. NaN: not counted.
struct TruthParameter {
  bool free = true;           // in every draw
  double error = 0.0;         // rms of fit - truth, parameter's unit
  double bound = 0.0;         // rms of Cramer-Rao's bound, coupled, same free set (coupled_bound.h)
  double identifiable = 0.0;  // share of the pixels whose bound is below kIdentifiable of the range's sigma
  double over_bound = 0.0;    // rms errors of the identifiable pixels over their bounds'
  // Of the pixels whose own sigma is below kIdentifiable and that carry no flag but that one:
  double claimed = 0.0;                             // their share
  double spread = 0.0;                              // rms of (fit - truth) / sigma
  std::array<double, kIntervals.size()> covered{};  // share of them whose interval holds the truth
};

struct TruthPoint {
  std::string scene, free;  // "auto", "all", "paper"
  std::string chosen;       // names of what was free in the first draw
  int size = 0, draws = 0;
  double chi2 = 0.0;  // mean
  std::array<TruthParameter, kUnknownCount> parameters;
};

// Light by the forward model at a tolerance of 1e-5, Gaussian noise of `noise` of the reflectance, nothing
// that pixels share. `bound`: whether Cramer-Rao's bound is counted (time and memory grow as the sixth and
// fourth power of `size`).
struct TruthSetting {
  std::string scene, free;
  int size = 24, draws = 4;
  double noise = 0.005;
  std::uint64_t seed = 1;
  bool bound = true;
};
// Measures settings; what those of one scene and size share is kept from one to the next.
class TruthBench {
 public:
  TruthBench();
  ~TruthBench();
  TruthPoint Measure(const TruthSetting& setting);

 private:
  struct Scene;
  void See(const TruthSetting& setting);
  std::unique_ptr<Scene> scene_;
};

// Monte Carlo's light on freckles over a vein, cells of 0.23 mm, its own noise (1.2 to 1.9 %), the default
// fit.
struct MonteCarloFit {
  int bands = 0;
  double melanin_bias = 0.0, melanin_median = 0.0, melanin_decile = 0.0;  // of (fit - truth) / truth
  double blood_bias = 0.0, blood_median = 0.0;  // of C_hd, where its sigma is below half of it
  double blood_known = 0.0;                     // share of those pixels
};
MonteCarloFit MeasureMonteCarloFit();

nlohmann::json ToJson(const TruthPoint& point);
TruthPoint TruthPointFromJson(const nlohmann::json& json);
nlohmann::json ToJson(const MonteCarloFit& fit);
MonteCarloFit MonteCarloFitFromJson(const nlohmann::json& json);

}  // namespace dermap
