// SPDX-License-Identifier: Apache-2.0
// Speed against accuracy: every way to render and to fit, on several scenes, each a point of time against
// error.
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
  std::uint64_t seed = 1;  // of the noise of what is fitted
};

// One setting on one scene.
struct TradeoffPoint {
  std::string kind;  // render, fit
  std::string scene, setting, family;
  std::string options{};                                  // in words
  int size = 0;                                           // pixels along a side
  double seconds = 0.0, ratio = 0.0, ratio_spread = 0.0;  // ratio: to the default, in pairs
  int pairs = 0;
  bool is_default = false, is_paper = false;
  bool extrapolated = false;  // the time: renders that were run, times what the whole would take
  // Render: rms relative to the slow reference, over cells of 0.23 mm. Fit: median errors to the truth over
  // what noise alone would leave in a pixel by itself (NoiseBound), mean of the five parameters.
  double error = 0.0, error_bar = 0.0;
  // Fit: the same to the maps of the reference fit; 0 of the reference fit itself.
  double error_reference = 0.0, reference_bar = 0.0;
  // Render: as `error`, to Monte Carlo, its noise taken out. Fit: median relative error of C_m where light is
  // Monte Carlo's. 0: the scene has none.
  double error_monte_carlo = 0.0, monte_carlo_bar = 0.0;
  // Fit: median |error| of the parameters, to the truth and to the reference fit, and the bound.
  ParameterVector to_truth{}, to_reference{}, bound{};
  double chi2 = 0.0;
  int renders = 0;
};

// Points of one kind, held to one judge, over time.
struct TradeoffChart {
  struct Dot {
    std::size_t point;  // into TradeoffStudy::points; where scenes are put together, that of the first
    double seconds, seconds_bar, error, error_bar;
  };
  std::string kind;                // render, fit
  std::string judge;               // slow reference, Monte Carlo, truth, reference fit
  std::string scene;               // "all": geometric means over the scenes, bars their spread
  std::vector<Dot> dots;           // those whose error is known
  std::vector<std::size_t> front;  // into dots, by time
  std::size_t shipped = 0;         // into dots
  bool shipped_on_front = false;
  std::string shipped_beaten_by{};  // a setting that is faster and more right by more than can be told apart
};

struct TradeoffStudy {
  TradeoffOptions options;
  int render_size = 0, fit_size = 0;  // pixels along a side of the patches
  std::string machine;
  double rounding = 0.0;  // what single precision does to a render, relative rms
  std::vector<TradeoffPoint> points;
  std::vector<TradeoffChart> charts;  // one for each kind, judge and scene
  std::vector<Verdict> verdicts;      // that hold on any machine
  std::vector<Verdict> timed;         // those about times
  int resumed = 0;                    // points taken over from an earlier run
};

// Measures what FOLDER/tradeoff.journal.jsonl lacks. Throws InputError where that journal is of other
// settings.
TradeoffStudy RunTradeoffStudy(const std::filesystem::path& folder, const TradeoffOptions& options,
                               const ProgressFunction& progress);

// tradeoff.csv, tradeoff.json, tradeoff.svg and tradeoff.html; together or not at all.
void WriteTradeoffStudy(const std::filesystem::path& folder, const TradeoffStudy& study);

// A chart for each kind, judge and scene, in the order of the points; with all scenes put together, one for
// each kind and judge. Settings that a scene lacks are left out there.
std::vector<TradeoffChart> ChartsOf(const std::vector<TradeoffPoint>& points);
std::vector<TradeoffChart> ChartsOfAllScenes(const std::vector<TradeoffPoint>& points);

}  // namespace dermap
