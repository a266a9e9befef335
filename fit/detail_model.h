// SPDX-License-Identifier: Apache-2.0
// What a fit knows of maps and data beside the pixels' values: how much detail there is, how far residuals
// scatter, how far skin blurs; all by octave.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "fit/blur_share.h"
#include "fit/octaves.h"
#include "fit/parameter_space.h"

namespace dermap {

// Where one of melanin's maps, its amount and its kind, has detail the other has, too; the others are apart.
enum class Pigment { kMelanin, kBloodEpidermis, kCarotene, kBloodDermis, kInk };
inline constexpr std::size_t kPigmentCount = 5;
Pigment PigmentOf(Parameter p);

// By pigment: variance of each pixel's details over the octave's; empty: not known.
using Activity = std::array<PlaneF, kPigmentCount>;

// What earlier fits say (fit/learnt_prior.h), in scaled units of the free parameters.
struct LinkedPrior {
  FreeVector mean{};              // of a patch
  FreeMatrix mean_precision{};    // inverse of the means' covariance
  FreeVector detail_variance{};   // of a pixel about its patch's mean, all octaves together
  FreeMatrix detail_precision{};  // inverse of their covariance
};

struct DetailModel {
  // Variance of a pixel's detail in scaled units, [octave][free parameter]; of the last octave, a single
  // pixel, of the mean's distance from average skin.
  std::vector<FreeVector> prior;
  // From how many details that is known, likewise; 0: it was not estimated.
  std::vector<FreeVector> details;
  std::vector<double>
      scatter;     // [octave], variance of the residuals over that of the stated noise, at least 1
  BlurTable blur;  // [octave][band]; octaves beyond are not blurred
  std::vector<Activity> activity;  // [octave]
  // Details of an octave are then as in earlier fits, times one factor, and so is `prior`; the mean's part of
  // `prior` says nothing.
  std::optional<LinkedPrior> link;
};

// Before anything is known.
inline constexpr double kFirstDetailSigma = 0.25;  // scaled units
DetailModel FirstDetailModel(int octaves, BlurTable blur, std::optional<LinkedPrior> link = {});

// Drops what of `before` is not in `after`, a part of it in the same order.
void KeepFree(const ParameterSpace& before, const ParameterSpace& after, DetailModel& detail);

// The same seen from pixels that are 2^first as large.
struct DetailView {
  std::span<FreeVector> prior, details;
  std::span<double> scatter;
  std::span<const std::vector<BlurCurve>> blur;
  std::span<Activity> activity;
  const LinkedPrior* link = nullptr;

  // Over the octave's variance. Null: 1 everywhere.
  const PlaneF* ActivityOf(std::size_t octave, GridShape shape, Parameter p) const;
};
DetailView ViewFrom(DetailModel& model, int first);

// Of an octave twice as fine.
Activity Enlarged(const Activity& coarse, GridShape fine);

// What an octave's variance is guessed to be from those of the two coarser ones.
double GuessedVariance(const DetailView& model, int octave, int j);

// Sums over the pixels of an octave from which the variances are estimated anew.
struct DetailStatistics {
  FreeVector squares{};         // of the details, over the pixels' activity
  FreeVector determined{};      // how far the data decide them: 1 a pixel if wholly, 0 if not at all
  double linked_squares = 0.0;  // of the details, over their covariance in earlier fits
  double pixels = 0.0;
  double residual_squares = 0.0;  // of what stays unanswered, over its stated noise
  double residual_count = 0.0;    // as many, less what the details adapted to
  double noise_share = 1.0;  // of the stated variance of residuals that is noise: the rest all pixels share
  // By pixel and pigment: squares over the prior, and how much of its parameters is determined.
  std::array<PlaneF, kPigmentCount> energy, told;
};
// Of all octaves, finest first. D. J. C. MacKay's fixed point: sum of squares over what the data determine.
void Update(std::span<const DetailStatistics> statistics, int count, DetailView model);

}  // namespace dermap
