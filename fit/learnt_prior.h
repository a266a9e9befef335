// SPDX-License-Identifier: Apache-2.0
// What fits of many bands teach about skin: a prior for images of few bands, such as RGB [D08 6, 7.2].
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/tissue/parameters.h"
#include "fit/detail_model.h"
#include "fit/fit_result.h"

namespace dermap {

using ParameterMatrix = std::array<ParameterVector, kParameterCount>;

// One patch that was learnt from.
struct PriorSource {
  std::string name;    // of the stack, for people
  std::string sha256;  // of its data at the size of the fit: the same patch counts once
};

// In the parameters' own units [D08 table 1], linear: the coordinates of the fits.
struct LearntPrior {
  std::vector<PriorSource> sources;     // as many as fits
  ParameterVector mean{};               // of the patches' means
  ParameterMatrix covariance{};         // of the patches' means, sum over the fits divided by their number
  ParameterMatrix detail_covariance{};  // of pixels about their patch's mean, mean over the fits

  int fits() const { return static_cast<int>(sources.size()); }
};

// Bands that a fit needs to teach: one more than table 1's parameters, so that nothing rests on assumptions.
inline constexpr int kTeachingBands = kParameterCount + 1;

// What one fit teaches. Details count as large as the maps hold them plus what sigma says may be hidden. A
// parameter that stayed at average skin's value because nothing spoke for another is known no better than its
// range. Throws InputError for a fit that has too few bands, did not converge, or is of method descent, whose
// maps hold noise as detail.
LearntPrior LearnFrom(const FitResult& fit, const std::string& name);

// Both together. Throws InputError where they share a patch.
LearntPrior Combined(const LearntPrior& a, const LearntPrior& b);

// For a fit's free parameters; those that are not free are integrated out. A few fits may be alike by chance:
// the ranges of table 1 count as one more fit's means, and the first guess at details as one more fit's
// details.
LinkedPrior LinkTo(const LearntPrior& prior, const ParameterSpace& space);

// docs/formats.md, "Prior". Reading throws InputError for whatever is not a prior: another version, numbers
// that are missing or not finite, means beyond table 1, matrices that are not symmetric and positive
// semidefinite. Writing throws StorageError.
LearntPrior ReadLearntPrior(const std::filesystem::path& path);
void WriteLearntPrior(const std::filesystem::path& path, const LearntPrior& prior);

}  // namespace dermap
