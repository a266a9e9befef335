// SPDX-License-Identifier: Apache-2.0
// The ladder of models: how much of the forward model scenes from uniform to wild are given by the engine's
// own choice, the time that this saves and the error that it costs, against the full one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "common/transport/forward_model.h"
#include "studies/verdict.h"

namespace dermap {

struct LadderOptions {
  bool quick = false;      // five scenes, small patches, one tolerance: for tests
  std::uint64_t seed = 1;  // of the scene of noise
};

struct LadderBand {
  double wavelength_nm = 0.0;
  BandChoice choice;
  double error = 0.0;  // of the render, rms over the mean, to the reference
};

// One scene at one tolerance.
struct LadderScene {
  std::string name;
  double tolerance = 0.0;
  std::vector<LadderBand> bands;
  double seconds = 0.0;  // of a render of all bands, median
  // Medians of pairs: than the full model at the same tolerance, which is what the wildest scene is given;
  // and than the reference, the full model at a tolerance of 1e-5.
  double times_faster = 0.0, faster_than_reference = 0.0;
  double ratio_spread = 0.0;  // of the first, relative
  double error = 0.0;         // largest of the bands
  double estimate = 0.0;      // likewise, the engine's own
};

struct LadderStudy {
  LadderOptions options;
  int size = 0;  // pixels along a side
  std::string machine;
  // The full model: as much of everything as the wildest scene is given at the default tolerance.
  int full_paths = 0, full_terms = 0;
  double full_margin_mm = 0.0;
  std::vector<LadderScene> scenes;  // from uniform to wild, for each tolerance
  std::vector<Verdict> verdicts;
  int resumed = 0;  // scenes taken over from an earlier run
};

// Measures what FOLDER/ladder.journal.jsonl lacks. Throws InputError where that journal is of other settings.
LadderStudy RunLadderStudy(const std::filesystem::path& folder, const LadderOptions& options,
                           const ProgressFunction& progress);

// ladder.csv, ladder.json, ladder.svg and ladder.html; together or not at all.
void WriteLadderStudy(const std::filesystem::path& folder, const LadderStudy& study);

nlohmann::json LadderRecord(const LadderScene& scene);
LadderScene LadderSceneFrom(const nlohmann::json& record);

// "8 full", "3 first-order, 5 full": how many bands took which rung.
std::string RungsInWords(const LadderScene& scene);

}  // namespace dermap
