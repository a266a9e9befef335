// SPDX-License-Identifier: Apache-2.0
// What a fit knows of maps and data beside the pixels' values: how much detail there is, how far residuals
// scatter, how far skin blurs; all by octave.
#pragma once

#include <span>
#include <vector>

#include "fit/blur_share.h"
#include "fit/parameter_space.h"

namespace dermap {

struct DetailModel {
  // Variance of a pixel's detail in scaled units, [octave][free parameter]; of the last octave, a single
  // pixel, of the mean's distance from average skin.
  std::vector<FreeVector> prior;
  std::vector<double>
      scatter;     // [octave], variance of the residuals over that of the stated noise, at least 1
  BlurTable blur;  // [octave][band]; octaves beyond are not blurred
};

// Before anything is known.
inline constexpr double kFirstDetailSigma = 0.25;  // scaled units
DetailModel FirstDetailModel(int octaves, BlurTable blur);

// The same seen from pixels that are 2^first as large.
struct DetailView {
  std::span<FreeVector> prior;
  std::span<double> scatter;
  std::span<const std::vector<BlurCurve>> blur;
};
DetailView ViewFrom(DetailModel& model, int first);

// What an octave's variance is guessed to be from those of the two coarser ones.
double GuessedVariance(std::span<const FreeVector> prior, int octave, int j);

// Sums over the pixels of an octave from which the variances are estimated anew.
struct DetailStatistics {
  FreeVector squares{};     // of the details
  FreeVector determined{};  // how far the data decide them: 1 a pixel if wholly, 0 if not at all
  double pixels = 0.0;
  double residual_squares = 0.0;  // of what stays unanswered, over its stated noise
  double residual_count = 0.0;    // as many, less what the details adapted to
};
// Of all octaves, finest first. D. J. C. MacKay's fixed point: sum of squares over what the data determine.
void Update(std::span<const DetailStatistics> statistics, int count, DetailView model);

}  // namespace dermap
