// SPDX-License-Identifier: Apache-2.0
// Speed against accuracy: every way to render and to fit, time against error, and whether the shipped
// defaults lie on the front.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "common/tissue/parameters.h"
#include "studies/verdict.h"

namespace dermap {

struct TradeoffOptions {
  bool quick = false;      // two scenes, small patches, few settings: for tests
  std::uint64_t seed = 1;  // of the noise
};

// One setting on one scene.
struct TradeoffPoint {
  std::string kind;  // render, fit
  std::string scene, setting, family;
  std::string options{};                                  // in words
  int size = 0;                                           // pixels along a side
  double seconds = 0.0, ratio = 0.0, ratio_spread = 0.0;  // ratio: to the default, in pairs
  int pairs = 0;
  bool is_default = false, is_paper = false, extrapolated = false;
  // Render: rms relative to the slow reference, over cells of 0.23 mm. Fit: median errors over what noise
  // alone would leave (NoiseBound), mean of the five parameters, to the truth.
  double error = 0.0, error_bar = 0.0;
  double error_monte_carlo = 0.0, monte_carlo_bar = 0.0;  // 0: the scene has none
  // Fit: median |error| of the parameters, to the truth and to the reference fit, and the bound.
  ParameterVector to_truth{}, to_reference{}, bound{};
  double chi2 = 0.0;
  int renders = 0;
};

// A chart: points of one kind, over their scenes (geometric means) or on the Monte Carlo scene.
struct TradeoffFront {
  struct Place {
    std::string setting, family, options;
    double seconds = 0.0, seconds_bar = 0.0, error = 0.0, error_bar = 0.0;
    bool is_default = false, is_paper = false, extrapolated = false, on_front = false, dominated = false;
  };
  std::string name, error_name;
  std::vector<Place> places;
};

struct TradeoffStudy {
  bool quick = false;
  std::uint64_t seed = 1;
  int size = 0;
  std::string machine;
  std::vector<TradeoffPoint> points;
  std::vector<TradeoffFront> fronts;
  std::vector<Verdict> verdicts;
  int resumed = 0;
};

// Points go to FOLDER/tradeoff.journal.jsonl as they are measured; a run that was broken off goes on.
TradeoffStudy RunTradeoffStudy(const std::filesystem::path& folder, const TradeoffOptions& options,
                               const ProgressFunction& progress);

// tradeoff.csv, .json, .svg and .html; together or not at all.
void WriteTradeoffStudy(const std::filesystem::path& folder, const TradeoffStudy& study);

}  // namespace dermap
