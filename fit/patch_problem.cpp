// SPDX-License-Identifier: Apache-2.0
// Renders, forward differences and local normal equations of a patch.
#include "fit/patch_problem.h"

#include <cassert>
#include <utility>

#include "common/core/parallel.h"

namespace dermap {

PatchProblem::PatchProblem(const FitData& data, const ForwardModel& model, ParameterSpace space)
    : data_(data), model_(model), space_(std::move(space)), fill_(data.fitted) {
  assert(model.band_count() == data.band_count());
}

ParameterMaps PatchProblem::UniformMaps(const SkinPoint& point) const {
  ParameterMaps maps(data_.width(), data_.height(), TableOne(point));
  if (space_.HasJunction())
    maps.junction_absorbance = {
        PlaneF(data_.width(), data_.height(), static_cast<float>(point[kParameterCount]))};
  return maps;
}

FitState PatchProblem::StateOf(ParameterMaps maps) {
  FitState state;
  fill_.Apply(maps);
  state.maps = std::move(maps);
  state.predicted = model_.Render(state.maps);
  state.misfit = Evaluate(data_, state.predicted);
  ++renders_;
  return state;
}

DerivativePlanes PatchProblem::ForwardDifferences(const FitState& state, double step) {
  const int bands = data_.band_count(), count = space_.count();
  DerivativePlanes derivatives(count);
  std::vector<ParameterMaps> raised(count, state.maps);
  std::vector<PlaneF> inverse_step(count, PlaneF(data_.width(), data_.height()));
  std::vector<std::pair<int, int>> tasks;
  for (int j = 0; j < count; ++j) {
    const ParameterInfo& info = InfoOf(space_.parameter(j));
    const float h = static_cast<float>(step * space_.scale(j));
    PlaneF& plane = raised[j].Unknown(space_.parameter(j));
    for (std::size_t i = 0; i < plane.size(); ++i) {
      const float before = plane.data()[i];
      const float after = before + h > static_cast<float>(info.upper) ? before - h : before + h;
      plane.data()[i] = after;
      // The difference that float kept, not the one asked for.
      inverse_step[j].data()[i] = static_cast<float>(space_.scale(j) / (static_cast<double>(after) - before));
    }
    derivatives[j].assign(bands, PlaneF(data_.width(), data_.height()));
    for (int b = 0; b < bands; ++b) tasks.emplace_back(j, b);
  }
  ParallelFor(static_cast<int>(tasks.size()), [&](int t) {
    const auto [j, b] = tasks[t];
    PlaneF& plane = derivatives[j][b];
    plane = model_.RenderBand(b, raised[j]);
    const float* base = state.predicted[b].data();
    for (std::size_t i = 0; i < plane.size(); ++i)
      plane.data()[i] = (plane.data()[i] - base[i]) * inverse_step[j].data()[i];
  });
  renders_ += count;
  return derivatives;
}

SkinPoint SensitivityOf(const ForwardModel& model, int band, const SkinPoint& point) {
  const ParameterVector p = TableOne(point);
  const BandOptics& optics = model.optics()[band];
  const Absorbers& absorbers = optics.nodes[optics.center].absorbers;
  const LogSensitivity local = model.LocalSensitivity(band, p, point[kParameterCount]);
  const ParameterVector epidermis = absorbers.MuAEpidermisGradient(p);
  const ParameterVector dermis = absorbers.MuADermisGradient(p);
  SkinPoint sensitivity;
  for (int k = 0; k < kParameterCount; ++k)
    sensitivity[k] = local.mu_a_epidermis * epidermis[k] + local.mu_a_dermis * dermis[k];
  sensitivity[kParameterCount] = local.junction_absorbance;
  return sensitivity;
}

PixelSystem LocalSystem(const PatchProblem& problem, std::size_t pixel, const SkinPoint& p,
                        const std::vector<PlaneF>* predicted, double* chi2) {
  const FitData& data = problem.data();
  const ParameterSpace& space = problem.space();
  PixelSystem system;
  system.count = space.count();
  if (chi2) *chi2 = 0.0;
  for (int b = 0; b < data.band_count(); ++b) {
    if (!data.Has(b, pixel)) continue;
    const SkinPoint sensitivity = SensitivityOf(problem.model(), b, p);
    const double rendered = predicted ? (*predicted)[b].data()[pixel]
                                      : problem.model().LocalReflectance(b, TableOne(p), p[kParameterCount]);
    const LogResidual datum =
        LogResidualOf(data.measured[b].data()[pixel], data.sigma[b].data()[pixel], rendered);
    FreeVector row{};
    for (int j = 0; j < space.count(); ++j)
      row[j] = sensitivity[static_cast<int>(space.parameter(j))] * space.scale(j) * datum.weight;
    system.Add(row, datum.residual);
    if (chi2) *chi2 += datum.residual * datum.residual;
  }
  return system;
}

}  // namespace dermap
