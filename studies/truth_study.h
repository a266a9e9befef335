// SPDX-License-Identifier: Apache-2.0
// The default fit on skin that is known: errors over what any fit could reach, error bars over errors, and
// whether the choice of what is free pays.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "studies/truth_point.h"
#include "studies/verdict.h"

namespace dermap {

struct TruthStudyOptions {
  bool quick = false;  // two scenes, one small size: for tests
  std::uint64_t seed = 1;
};

struct TruthStudy {
  TruthStudyOptions options;
  std::vector<TruthPoint> points;
  MonteCarloFit monte_carlo;  // bands 0: not measured (quick)
  std::vector<Verdict> verdicts;
};

// The chosen set's errors over another's, geometric mean over table 1's parameters. NaN where either is
// missing.
double ErrorRatio(const TruthStudy& study, const TruthPoint& chosen, const std::string& other);

// Measures what FOLDER/truth.journal.jsonl lacks. Throws InputError where that journal is of other settings.
TruthStudy RunTruthStudy(const std::filesystem::path& folder, const TruthStudyOptions& options,
                         const ProgressFunction& progress);

// truth.csv, .json, .svg and .html; together or not at all.
void WriteTruthStudy(const std::filesystem::path& folder, const TruthStudy& study);

}  // namespace dermap
