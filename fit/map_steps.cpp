// SPDX-License-Identifier: Apache-2.0
// Skins, larger maps, fixed values.
#include "fit/map_steps.h"

#include <algorithm>
#include <utility>

#include "common/core/parallel.h"
#include "fit/octaves.h"

namespace dermap {

std::vector<ParameterVector> SkinsOf(const PatchProblem& problem, const ParameterMaps& maps) {
  std::vector<std::pair<float, std::size_t>> by_melanin;
  for (std::size_t i = 0; i < problem.data().fitted.size(); ++i)
    if (problem.data().fitted.data()[i]) by_melanin.emplace_back(maps[Parameter::kC_m].data()[i], i);
  std::sort(by_melanin.begin(), by_melanin.end());
  std::vector<ParameterVector> skins;
  for (const double quantile : {0.02, 0.98}) {
    const auto middle = static_cast<std::size_t>(quantile * static_cast<double>(by_melanin.size() - 1));
    const std::size_t reach = by_melanin.size() / 64;
    const std::size_t begin = middle - std::min(middle, reach);
    const std::size_t end = std::min(middle + reach + 1, by_melanin.size());
    ParameterVector mean{};
    for (std::size_t k = begin; k < end; ++k)
      for (int j = 0; j < kParameterCount; ++j)
        mean[j] += maps.planes[j].data()[by_melanin[k].second] / static_cast<double>(end - begin);
    skins.push_back(mean);
  }
  return skins;
}

ParameterMaps Enlarged(const PatchProblem& problem, const ParameterMaps& maps) {
  const GridShape shape{problem.data().width(), problem.data().height()};
  ParameterMaps large;
  ParallelFor(kParameterCount, [&](int i) { large.planes[i] = Double(maps.planes[i], shape); });
  for (const PlaneF& plane : maps.junction_absorbance)
    large.junction_absorbance.push_back(Double(plane, shape));
  for (const Parameter p : problem.space().free())
    for (float& value : large.Unknown(p).values())
      value = std::clamp(value, static_cast<float>(InfoOf(p).lower), static_cast<float>(InfoOf(p).upper));
  return large;
}

SkinPoint FixedBy(const Candidate& candidate, SkinPoint fixed) {
  for (const Parameter p : candidate.absent) fixed[static_cast<int>(p)] = 0.0;
  return fixed;
}

ParameterMaps WithFixed(const ParameterSpace& space, const ParameterMaps& maps, const SkinPoint& fixed) {
  ParameterMaps out = maps;
  for (const Parameter p : AllUnknowns()) {
    if (std::find(space.free().begin(), space.free().end(), p) != space.free().end()) continue;
    if (p == Parameter::kJunctionAbsorbance)
      out.junction_absorbance.clear();
    else
      for (float& value : out[p].values()) value = static_cast<float>(fixed[static_cast<int>(p)]);
  }
  return out;
}

ParameterMaps WithJunction(ParameterMaps maps, double absorbance) {
  if (maps.junction_absorbance.empty())
    maps.junction_absorbance.emplace_back(maps.width(), maps.height(), static_cast<float>(absorbance));
  return maps;
}

ParameterMaps ChangeOfPixel(const ParameterSpace& space, int j, std::size_t pixel, int width, int height) {
  ParameterMaps change;
  if (space.HasJunction()) change.junction_absorbance = {PlaneF(width, height)};
  const Parameter p = space.parameter(j);
  if (p != Parameter::kJunctionAbsorbance) change[p] = PlaneF(width, height);
  change.Unknown(p).data()[pixel] = static_cast<float>(space.scale(j));
  return change;
}

}  // namespace dermap
