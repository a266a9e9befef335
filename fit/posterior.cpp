// SPDX-License-Identifier: Apache-2.0
// Misfit and prior with their gradients.
#include "fit/posterior.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/core/parallel.h"
#include "fit/octave_solver.h"

namespace dermap {
namespace {

double HalfChi2(const FitData& data, int band, const PlaneF& predicted, double scatter, PlaneF* weights) {
  double sum = 0.0;
  if (weights) *weights = PlaneF(predicted.width(), predicted.height());
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    if (!data.fitted.data()[i] || !data.Has(band, i)) continue;
    const double reflectance = predicted.data()[i];
    const LogResidual datum =
        LogResidualOf(data.measured[band].data()[i], data.sigma[band].data()[i], reflectance);
    sum += datum.residual * datum.residual;
    if (weights)
      weights->data()[i] =
          static_cast<float>(-datum.residual * datum.weight / (std::max(reflectance, 1e-7) * scatter));
  }
  return 0.5 * sum / scatter;
}

}  // namespace

Posterior::Posterior(const PatchProblem& problem, const DetailView& detail, const SkinPoint& fixed)
    : problem_(problem),
      detail_(detail),
      fixed_(fixed),
      shapes_(OctaveShapes(problem.data().width(), problem.data().height())) {}

Posterior::Position Posterior::PositionOf(const ParameterMaps& maps) const {
  const ParameterSpace& space = problem_.space();
  Position position;
  for (int j = 0; j < space.count(); ++j) {
    PlaneF& plane = position.emplace_back(maps.Unknown(space.parameter(j)));
    for (float& value : plane.values()) value = static_cast<float>(value / space.scale(j));
  }
  return position;
}

ParameterMaps Posterior::MapsOf(const Position& position) const {
  const ParameterSpace& space = problem_.space();
  ParameterMaps maps = problem_.UniformMaps(fixed_);
  for (int j = 0; j < space.count(); ++j) {
    PlaneF& plane = maps.Unknown(space.parameter(j));
    const ParameterInfo& info = InfoOf(space.parameter(j));
    for (std::size_t i = 0; i < plane.size(); ++i)
      plane.data()[i] =
          static_cast<float>(std::clamp(position[j].data()[i] * space.scale(j), info.lower, info.upper));
  }
  return maps;
}

double Posterior::Value(const Position& position) const {
  const std::vector<PlaneF> predicted = problem_.model().Render(MapsOf(position));
  double value = PriorValue(position);
  for (std::size_t b = 0; b < predicted.size(); ++b)
    value += HalfChi2(problem_.data(), static_cast<int>(b), predicted[b], detail_.scatter[0], nullptr);
  return value;
}

double Posterior::ValueAndGradient(const Position& position, Position& gradient) const {
  const ParameterSpace& space = problem_.space();
  std::vector<double> misfit(problem_.data().bands.size());
  const ParameterMaps derivatives =
      problem_.model().Transpose(MapsOf(position), [&](int band, const PlaneF& reflectance) {
        PlaneF weights;
        misfit[band] = HalfChi2(problem_.data(), band, reflectance, detail_.scatter[0], &weights);
        return weights;
      });
  const double prior = PriorValueAndGradient(position, gradient);
  for (int j = 0; j < space.count(); ++j) {
    const PlaneF& derivative = derivatives.Unknown(space.parameter(j));
    for (std::size_t i = 0; i < derivative.size(); ++i) {
      const float at = position[j].data()[i];
      if (at >= space.lower()[j] && at <= space.upper()[j])
        gradient[j].data()[i] += static_cast<float>(derivative.data()[i] * space.scale(j));
    }
  }
  return std::accumulate(misfit.begin(), misfit.end(), prior);
}

// Of the plane of an octave and all coarser ones: half the details' squares over their variances.
double Posterior::AddPrior(const PlaneF& plane, int j, std::size_t octave, PlaneF* gradient) const {
  const bool top = octave + 1 == shapes_.size();
  const double precision = (top ? 1.0 : kDetailShare) / detail_.prior[octave][j];
  PlaneF weighted = plane;
  if (!top) weighted = DetailOf(plane);
  double sum = 0.0;
  const PlaneF* activity = detail_.ActivityOf(octave, shapes_[octave], problem_.space().parameter(j));
  for (std::size_t i = 0; i < weighted.size(); ++i) {
    float& value = weighted.data()[i];
    const double detail = top ? value - problem_.space().mean()[j] : value;
    const double here = activity ? precision / activity->data()[i] : precision;
    sum += 0.5 * here * detail * detail;
    value = static_cast<float>(here * detail);
  }
  if (top) {
    if (gradient) *gradient = std::move(weighted);
    return sum;
  }
  PlaneF coarser;
  sum += AddPrior(Halve(plane), j, octave + 1, gradient ? &coarser : nullptr);
  if (gradient) {
    *gradient = DetailTransposed(weighted);
    const PlaneF from_coarser = HalveTransposed(coarser, shapes_[octave]);
    for (std::size_t i = 0; i < gradient->size(); ++i) gradient->data()[i] += from_coarser.data()[i];
  }
  return sum;
}

double Posterior::PriorValue(const Position& position) const {
  double sum = 0.0;
  for (std::size_t j = 0; j < position.size(); ++j)
    sum += AddPrior(position[j], static_cast<int>(j), 0, nullptr);
  return sum;
}

double Posterior::PriorValueAndGradient(const Position& position, Position& gradient) const {
  gradient.assign(position.size(), PlaneF());
  std::vector<double> sums(position.size());
  ParallelFor(static_cast<int>(position.size()),
              [&](int j) { sums[j] = AddPrior(position[j], j, 0, &gradient[j]); });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

}  // namespace dermap
