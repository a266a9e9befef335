// SPDX-License-Identifier: Apache-2.0
// What a fit returns: maps with error bars, predictions, flags and the record of how it went. Not converging
// is a result, never an exception.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/tissue/parameters.h"
#include "common/transport/forward_model.h"
#include "fit/candidate.h"

namespace dermap {

// Bits of flags.exr, one mask a pixel.
enum FitFlag : std::uint32_t {
  kFlagAtBound = 1,    // a free parameter ended at a bound of [D08 table 1]
  kFlagSaturated = 2,  // masked in the stack: saturated, dead or invalid; parameters are the neighbours' mean
  kFlagNotConverged = 4,      // the pixel's own residual is far above its noise
  kFlagNotIdentifiable = 8,   // sigma of a free parameter exceeds kIdentifiable of what its range alone says
  kFlagOutsideValidity = 16,  // reflectance outside what the model can produce
  kFlagUnexplained = 32,  // residuals widened a sigma to kUnexplainedWidening times what noise alone leaves
};
// By bit.
inline constexpr std::array<const char*, 6> kFitFlagNames{
    "at a bound", "masked", "not converged", "not identifiable", "outside the model", "unexplained"};

inline constexpr double kIdentifiable = 0.5;  // of range / sqrt(12), the sigma of a range alone

struct FitIteration {
  int iteration = 0;
  int renders = 0;  // full-patch renders so far
  double seconds = 0.0;
  double rms_residual = 0.0;  // over all valid pixels and bands, reflectance
  double chi2 = 0.0;          // per degree of freedom
};

struct FitResult {
  std::vector<Band> bands;
  ImagingConditions
      conditions;  // pixel size of the fit (larger than the stack's when it ran at a reduced size)
  ParameterMaps maps;
  ParameterMaps sigma;  // one standard deviation; 0 for what was not free
  std::vector<Parameter> free_parameters;
  std::vector<Candidate> candidates;  // sets of free parameters that were weighed; the first was chosen
  std::vector<PlaneF> measured;       // at the size of the fit
  std::vector<PlaneF> predicted;
  std::vector<PlaneF> residual;  // measured - predicted
  std::vector<PlaneF> noise;     // one standard deviation that chi2 is counted in
  Plane<std::uint32_t> flags;
  PlaneF chi2_map;  // per degree of freedom of a pixel
  std::vector<FitIteration> history;

  double rms_residual = 0.0;
  std::vector<double> rms_residual_per_band;
  double chi2 = 0.0;  // per degree of freedom
  double chi2_per_datum = 0.0;
  std::size_t data_count = 0;
  double degrees_of_freedom = 0.0;  // data less what the fit adapted to; `decisions` says how it was counted
  double seconds = 0.0;
  int renders = 0;
  bool converged = false;
  double unexplained_share = 0.0;  // of the fitted pixels: kFlagNotConverged or kFlagUnexplained
  bool Explained() const { return unexplained_share <= 0.5; }
  bool finished = true;  // false: it was stopped on the way; --resume goes on
  std::vector<std::pair<std::string, std::string>> settings;  // what decided it (fit/resume.h)
  std::string method;                                         // descent, ...
  std::string profiles;                                       // multipole, ...
  std::string engine;                                         // cascade, pyramid
  double tolerance = 0.0;                                     // of a render, relative
  std::vector<BandChoice> forward;     // what the engine `lowrank` took for each band in the last render
  std::vector<std::string> decisions;  // sentences: what the program decided by itself, and why
};

}  // namespace dermap
