// SPDX-License-Identifier: Apache-2.0
// Estimates of detail and scatter.
#include "fit/detail_model.h"

#include <algorithm>
#include <utility>

#include "fit/window_sums.h"

namespace dermap {
namespace {

constexpr double kSmallestVariance = 1e-9, kLargestVariance = 1.0;  // scaled units: 1 is that of the range
// An octave's variance is guessed to fall from that of the next coarser one as that fell from the one before,
// within limits: natural maps hold less detail the finer it is. The guess counts as if so many pixels, and
// such a share of all, had been seen: it decides where an octave has a handful of pixels or the data hardly
// reach.
constexpr double kSteepestFall = 0.12, kGuessFall = 0.5, kGuessPixels = 2.0, kGuessShare = 0.02;
// The guess at the scatter counts as if so many data had been seen.
constexpr double kScatterData = 6.0;
// The guess at a pixel's activity counts as if so many details had been seen.
constexpr double kActivityData = 4.0, kLargestActivity = 30.0;
constexpr int kActivityReach = 1;  // pixels around that it is estimated from
// Of an octave's details over those of all octaves in earlier fits, variances.
constexpr double kSmallestFactor = 1e-6, kLargestFactor = 100.0;

// Noise that is larger than stated is so in every octave. An error that neighbours share does not average
// away: against the noise of means of four pixels it is four times as large as against that of one. Which of
// both it is shows in how scatter grew.
double GuessedScatter(std::span<const double> scatter, int octave) {
  if (octave == 0) return 1.0;
  const double excess = scatter[octave - 1] - 1.0;
  if (octave == 1) return 1.0 + excess;
  return 1.0 + excess * std::clamp(excess / std::max(scatter[octave - 2] - 1.0, 1e-3), 1.0, 4.0);
}

// The mean of a patch is known so well that errors of calibration and optics, which all pixels share and
// finer octaves do not show, may far exceed its noise. Where residuals exceed it, the guess is dropped; what
// stays is a variance from a handful of data, whose own uncertainty (Student's t) widens it by n / (n - 2),
// at most 5: that is what two data ask for.
double UnforeseenScatter(const DetailStatistics& mean, std::span<const double> scatter, int octave) {
  constexpr double kUnforeseen = 2.0;  // times the noise: chance does that to three data once in nine times
  const double count = mean.residual_count;
  if (count < 0.5) return 0.0;
  const double found = mean.residual_squares / count;
  return found > kUnforeseen * mean.noise_share * GuessedScatter(scatter, octave)
             ? found * count / std::max(count - 2.0, 0.2 * count)
             : 0.0;
}

// Where a coarser octave has detail the finer ones have it, too (M. J. Wainwright and E. P. Simoncelli, NIPS
// 12, 2000: scale mixtures of Gaussians). Skin is quiet between freckles: what the data cannot tell there
// does not vary as it does at their edges.
// `energy` and `told` by pixel: squares over the octave's variance, and how many details they determine.
PlaneF ActivityFrom(const PlaneF& energy, const PlaneF& told, const PlaneF& coarser) {
  const GridShape shape{energy.width(), energy.height()};
  PlaneF activity = coarser.empty() ? PlaneF(shape.width, shape.height, 1.0f) : Interpolate(coarser, shape);
  const PlaneF squares = SumsAround(energy, kActivityReach), details = SumsAround(told, kActivityReach);
  for (std::size_t i = 0; i < activity.size(); ++i) {
    float& value = activity.data()[i];
    const double count = std::max(details.data()[i], 0.0f) + kActivityData;
    value = static_cast<float>(std::clamp((squares.data()[i] + kActivityData * value) / count,
                                          1.0 / kLargestActivity, kLargestActivity));
  }
  return activity;
}

// One factor for the covariance of all parameters' details.
void UpdateLinked(const DetailStatistics& octave, int count, double weight, int l, DetailView model) {
  const FreeVector& unit = model.link->detail_variance;
  const double guess = GuessedVariance(model, l, 0) / unit[0];
  double determined = 0.0;
  for (int j = 0; j < count; ++j) determined += octave.determined[j];
  const double factor = std::clamp(
      (octave.linked_squares + weight * count * guess) / (std::max(determined, 0.0) + weight * count),
      kSmallestFactor, kLargestFactor);
  for (int j = 0; j < count; ++j) model.prior[l][j] = factor * unit[j];
}

}  // namespace

Pigment PigmentOf(Parameter p) {
  switch (p) {
    case Parameter::kC_m:
    case Parameter::kBeta_m:
      return Pigment::kMelanin;
    case Parameter::kC_he:
      return Pigment::kBloodEpidermis;
    case Parameter::kC_bc:
      return Pigment::kCarotene;
    case Parameter::kC_hd:
      return Pigment::kBloodDermis;
    default:
      return Pigment::kInk;
  }
}

DetailModel FirstDetailModel(int octaves, BlurTable blur, std::optional<LinkedPrior> link) {
  FreeVector variance;
  variance.fill(kFirstDetailSigma * kFirstDetailSigma);
  if (link)
    for (int j = 0; j < kUnknownCount; ++j) variance[j] = link->detail_variance[j] / std::max(octaves - 1, 1);
  DetailModel model{std::vector<FreeVector>(octaves, variance),
                    std::vector<FreeVector>(octaves, FreeVector{}),
                    std::vector<double>(octaves, 1.0),
                    std::move(blur),
                    std::vector<Activity>(octaves),
                    std::move(link)};
  model.prior.back().fill(kLargestVariance);
  return model;
}

void KeepFree(const ParameterSpace& before, const ParameterSpace& after, DetailModel& detail) {
  for (std::vector<FreeVector>* vectors : {&detail.prior, &detail.details})
    for (FreeVector& vector : *vectors) {
      const FreeVector all = vector;
      for (int j = 0, k = 0; j < before.count(); ++j)
        if (k < after.count() && before.parameter(j) == after.parameter(k)) vector[k++] = all[j];
    }
}

DetailView ViewFrom(DetailModel& model, int first) {
  const std::size_t seen = std::min(static_cast<std::size_t>(first), model.blur.size());
  return {std::span(model.prior).subspan(first),
          std::span(model.details).subspan(first),
          std::span(model.scatter).subspan(first),
          std::span<const std::vector<BlurCurve>>(model.blur).subspan(seen),
          std::span(model.activity).subspan(first),
          model.link ? &*model.link : nullptr};
}

double GuessedVariance(const DetailView& model, int octave, int j) {
  const std::span<const FreeVector> prior = model.prior;
  const int top = static_cast<int>(prior.size()) - 1;
  if (octave + 1 >= top)
    return model.link ? model.link->detail_variance[j] / std::max(top, 1)
                      : kFirstDetailSigma * kFirstDetailSigma;
  if (octave + 2 >= top) return kGuessFall * prior[octave + 1][j];
  const double fall = prior[octave + 1][j] / prior[octave + 2][j];
  return prior[octave + 1][j] * std::clamp(fall, kSteepestFall, kGuessFall);
}

const PlaneF* DetailView::ActivityOf(std::size_t octave, GridShape shape, Parameter p) const {
  if (link || octave + 1 >= prior.size()) return nullptr;
  const PlaneF& plane = activity[octave][static_cast<std::size_t>(PigmentOf(p))];
  return plane.width() == shape.width && plane.height() == shape.height ? &plane : nullptr;
}

Activity Enlarged(const Activity& coarse, GridShape fine) {
  Activity enlarged;
  for (std::size_t p = 0; p < kPigmentCount; ++p)
    if (!coarse[p].empty()) enlarged[p] = Interpolate(coarse[p], fine);
  return enlarged;
}

void Update(std::span<const DetailStatistics> statistics, int count, DetailView model) {
  const int top = static_cast<int>(statistics.size()) - 1;
  for (int l = top - 1; l >= 0; --l) {
    const DetailStatistics& octave = statistics[l];
    const double weight = kGuessPixels + kGuessShare * octave.pixels;
    if (model.link) {
      UpdateLinked(octave, count, weight, l, model);
      continue;
    }
    for (int j = 0; j < count; ++j) {
      model.details[l][j] = std::max(octave.determined[j], 0.0) + weight;
      model.prior[l][j] =
          std::clamp((octave.squares[j] + weight * GuessedVariance(model, l, j)) / model.details[l][j],
                     kSmallestVariance, kLargestVariance);
    }
    for (std::size_t p = 0; p < kPigmentCount; ++p)
      if (!octave.energy[p].empty())
        model.activity[l][p] =
            ActivityFrom(octave.energy[p], octave.told[p], l + 1 < top ? model.activity[l + 1][p] : PlaneF());
  }
  for (int l = 0; l <= top; ++l) {
    const double guess = GuessedScatter(model.scatter, l);
    model.scatter[l] = std::max(1.0, (statistics[l].residual_squares + kScatterData * guess) /
                                         (statistics[l].residual_count + kScatterData));
  }
  model.scatter[top] = std::max(model.scatter[top], UnforeseenScatter(statistics[top], model.scatter, top));
}

}  // namespace dermap
