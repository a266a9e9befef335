// SPDX-License-Identifier: Apache-2.0
// Linearising at the pixels, and coarsening.
#include "fit/octave_levels.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"
#include "fit/resample.h"

namespace dermap {
namespace {

std::vector<PlaneF> HalveAll(const std::vector<PlaneF>& planes) {
  std::vector<PlaneF> halved(planes.size());
  ParallelFor(static_cast<int>(planes.size()), [&](int i) { halved[i] = Halve(planes[i]); });
  return halved;
}

// A hair or a grain of dust is no skin: pixels whose whole spectrum is far off count less, as a heavy-tailed
// noise would have it. Off means beyond what half of the patch is, so that no step on the way is taken for
// dust.
constexpr double kHonest = 6.0;  // squared misfit a datum, over the patch's median (at least 1)

PlaneF TrustOf(const PatchProblem& problem, const FitState& state) {
  const FitData& data = problem.data();
  PlaneF misfit(data.width(), data.height());
  std::vector<float> known;
  for (std::size_t i = 0; i < misfit.size(); ++i) {
    int count = 0;
    for (int b = 0; b < data.band_count(); ++b) count += data.Has(b, i);
    if (!data.fitted.data()[i] || count == 0) continue;
    misfit.data()[i] = static_cast<float>(state.misfit.chi2_map.data()[i] / count);
    known.push_back(misfit.data()[i]);
  }
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  const float honest = static_cast<float>(kHonest) * std::max(*middle, 1.0f);
  for (float& value : misfit.values()) value = value > honest ? honest / value : 1.0f;
  return misfit;
}

void SensePixel(const PatchProblem& problem, const FitState& state, float trust, std::size_t pixel,
                OctaveLevel& level) {
  const FitData& data = problem.data();
  const ParameterSpace& space = problem.space();
  const SkinPoint p = problem.PointAt(state.maps, pixel);
  const FreeVector position = space.FromParameters(p);
  for (int j = 0; j < space.count(); ++j) level.position[j].data()[pixel] = static_cast<float>(position[j]);
  for (int b = 0; b < data.band_count(); ++b) {
    const LogSensitivity local = problem.model().LocalSensitivity(b, TableOne(p), p[kParameterCount]);
    level.epidermis[b].data()[pixel] = static_cast<float>(local.mu_a_epidermis);
    level.dermis[b].data()[pixel] = static_cast<float>(local.mu_a_dermis);
    if (!level.junction.empty())
      level.junction[b].data()[pixel] = static_cast<float>(local.junction_absorbance);
    if (!data.fitted.data()[pixel] || !data.Has(b, pixel)) continue;
    const LogResidual datum = LogResidualOf(data.measured[b].data()[pixel], data.sigma[b].data()[pixel],
                                            state.predicted[b].data()[pixel]);
    level.residual[b].data()[pixel] = static_cast<float>(datum.residual / datum.weight);
    level.weight[b].data()[pixel] = static_cast<float>(trust * datum.weight * datum.weight);
  }
}

void Sense(const PatchProblem& problem, const FitState& state, OctaveLevel& level) {
  const PlaneF zero(level.shape.width, level.shape.height);
  const std::size_t bands = problem.data().bands.size();
  level.residual.assign(bands, zero);
  level.weight = level.epidermis = level.dermis = level.residual;
  if (problem.space().HasJunction()) level.junction = level.residual;
  level.position.assign(problem.space().count(), zero);
  const PlaneF trust = TrustOf(problem, state);
  ParallelFor(level.shape.height, [&](int y) {
    const std::size_t begin = static_cast<std::size_t>(y) * level.shape.width;
    for (std::size_t i = begin; i < begin + level.shape.width; ++i)
      SensePixel(problem, state, trust.data()[i], i, level);
  });
}

// Weighted means.
void CoarsenResidual(const OctaveLevel& fine, OctaveLevel& coarse) {
  const std::size_t bands = fine.weight.size();
  coarse.residual.resize(bands);
  coarse.weight.resize(bands);
  ParallelFor(static_cast<int>(bands), [&](int b) {
    PlaneF weighted = fine.residual[b];
    for (std::size_t i = 0; i < weighted.size(); ++i) weighted.data()[i] *= fine.weight[b].data()[i];
    coarse.residual[b] = HalveSum(weighted);
    coarse.weight[b] = HalveSum(fine.weight[b]);
    for (std::size_t i = 0; i < coarse.residual[b].size(); ++i)
      coarse.residual[b].data()[i] /= std::max(coarse.weight[b].data()[i], 1e-30f);
  });
}

// The weights of a single pixel, with the error that all data share.
void LimitWeights(OctaveLevel& mean) {
  const double shared = mean.shared_error * mean.shared_error / mean.noise_inflation;
  for (PlaneF& plane : mean.weight)
    for (float& weight : plane.values())
      weight = static_cast<float>(weight / (1.0 + shared * static_cast<double>(weight)));
}

void Coarsen(const OctaveLevel& fine, OctaveLevel& coarse) {
  CoarsenResidual(fine, coarse);
  coarse.epidermis = HalveAll(fine.epidermis);
  coarse.dermis = HalveAll(fine.dermis);
  coarse.junction = HalveAll(fine.junction);
  coarse.position = HalveAll(fine.position);
}

}  // namespace

void CoarsenResiduals(std::vector<OctaveLevel>& levels) {
  for (std::size_t l = 0; l + 1 < levels.size(); ++l) CoarsenResidual(levels[l], levels[l + 1]);
  if (levels.size() > 1) LimitWeights(levels.back());
}

std::vector<OctaveLevel> LineariseInOctaves(const PatchProblem& problem, const FitState& state,
                                            double shared_error) {
  const FitData& data = problem.data();
  std::vector<OctaveLevel> levels;
  double side = 1.0;
  for (const GridShape shape : OctaveShapes(data.width(), data.height())) {
    OctaveLevel& level = levels.emplace_back();
    level.shape = shape;
    level.shared_error = std::hypot(shared_error, 0.5 * problem.model().options().tolerance);
    level.noise_inflation = MeanNoiseInflation(data, side);
    side *= 2.0;
    if (levels.size() == 1)
      Sense(problem, state, level);
    else
      Coarsen(levels[levels.size() - 2], level);
  }
  if (levels.size() > 1) LimitWeights(levels.back());
  for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
    levels[l].detail.resize(levels[l].position.size());
    ParallelFor(problem.space().count(), [&](int j) {
      PlaneF& detail = levels[l].detail[j];
      detail = Double(levels[l + 1].position[j], levels[l].shape);
      for (std::size_t i = 0; i < detail.size(); ++i)
        detail.data()[i] = levels[l].position[j].data()[i] - detail.data()[i];
    });
  }
  levels.back().detail = levels.back().position;
  for (int j = 0; j < problem.space().count(); ++j)
    for (float& value : levels.back().detail[j].values())
      value -= static_cast<float>(problem.space().mean()[j]);
  return levels;
}

}  // namespace dermap
