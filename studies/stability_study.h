// SPDX-License-Identifier: Apache-2.0
// Where each method of fitting breaks, and whether it says so: one thing after another made worse until the
// maps are wrong.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "studies/stability_point.h"
#include "studies/verdict.h"

namespace dermap {

struct StabilityStudyOptions {
  bool quick = false;  // three values a sweep, small patches, one noise: for tests
  std::uint64_t seed = 1;
  std::vector<std::string> sweeps;   // by name; empty: all
  std::vector<std::string> methods;  // of fitting; empty: all, or the default one if quick
};

// Where a method stops being right on a sweep: its error first exceeds twice what noise allows.
struct StabilityEdge {
  std::string sweep, method, axis, judge;
  bool found = false;  // else right over the whole sweep
  double inside = 0.0,
         outside = 0.0;    // last value that is right, first that is not, away from the harmless one
  std::string response{};  // what the program does beyond: Response()
};

struct StabilityStudy {
  StabilityStudyOptions options;
  std::string machine;
  std::vector<StabilityPoint> points;
  std::vector<StabilityEdge> edges;         // below and above the harmless value, as far as there are values
  std::vector<std::size_t> silently_wrong;  // into points
  std::vector<std::size_t> flagged_inside;  // right, yet more than kFlaggedInside of the pixels flagged
  std::vector<Verdict> verdicts;
};

inline constexpr double kEdgeExcess = 2.0;

// Goes on with what FOLDER/stability.journal.jsonl holds.
StabilityStudy RunStabilityStudy(const std::filesystem::path& folder, const StabilityStudyOptions& options,
                                 const ProgressFunction& progress);

// "refused", "flagged" (most pixels), "wide intervals", "not converged" or "silent".
std::string Response(const StabilityPoint& point);

// stability.csv, .json, .svg and .html; together or not at all.
void WriteStabilityStudy(const std::filesystem::path& folder, const StabilityStudy& study);

}  // namespace dermap
