// SPDX-License-Identifier: Apache-2.0
// How far the forward model is from Monte Carlo beside an edge of melanin, over how sharp the edge is: where
// "slowly varying relative to the mean free path" [D08 4.1] ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "studies/judged_strip.h"
#include "studies/verdict.h"

namespace dermap {

struct SharpnessStudyOptions {
  bool quick = false;  // few edges and photons: for tests
  std::uint64_t seed = 1;
};

// C_m rises from 0.05 to 0.3 along a strip; the middle 80 % of the rise is this wide.
struct SharpnessPoint {
  double width_mm = 0.0, width_per_mean_free_path = 0.0;
  StripMisfit reciprocal, gather, published;  // exact optics in both couplings; [D08]'s multipole, gathering
};

struct SharpnessStudy {
  double wavelength_nm = 560.0;
  std::uint64_t photons = 0, seed = 0;
  std::vector<SharpnessPoint> points;
  std::vector<Verdict> verdicts;
  // Narrowest edge, in mean free paths, from which on gather coupling is within 2 %; 0 if it never is.
  double gather_edge = 0.0;
};

SharpnessStudy RunSharpnessStudy(const SharpnessStudyOptions& options, const ProgressFunction& progress);

// sharpness.csv, .json and .svg; together or not at all.
void WriteSharpnessStudy(const std::filesystem::path& folder, const SharpnessStudy& study);

}  // namespace dermap
