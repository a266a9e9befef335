// SPDX-License-Identifier: Apache-2.0
// Scaled free parameters.
#include "fit/parameter_space.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dermap {

ParameterVector TableOne(const SkinPoint& point) {
  ParameterVector p;
  std::copy_n(point.begin(), kParameterCount, p.begin());
  return p;
}

SkinPoint PointOf(const ParameterVector& p, double junction_absorbance) {
  SkinPoint point;
  std::copy_n(p.begin(), kParameterCount, point.begin());
  point[kParameterCount] = junction_absorbance;
  return point;
}

ParameterSpace::ParameterSpace(std::vector<Parameter> free) : free_(std::move(free)) {
  for (int j = 0; j < count(); ++j) {
    const ParameterInfo& info = InfoOf(free_[j]);
    scale_[j] = (info.upper - info.lower) / std::sqrt(12.0);
    lower_[j] = info.lower / scale_[j];
    upper_[j] = info.upper / scale_[j];
    mean_[j] = info.mean / scale_[j];
  }
}

bool ParameterSpace::HasJunction() const {
  return std::find(free_.begin(), free_.end(), Parameter::kJunctionAbsorbance) != free_.end();
}

FreeVector ParameterSpace::FromParameters(const SkinPoint& p) const {
  FreeVector u{};
  for (int j = 0; j < count(); ++j) u[j] = p[static_cast<int>(free_[j])] / scale_[j];
  return u;
}

void ParameterSpace::ToParameters(const FreeVector& u, SkinPoint& p) const {
  for (int j = 0; j < count(); ++j) {
    const ParameterInfo& info = InfoOf(free_[j]);
    p[static_cast<int>(free_[j])] = std::clamp(u[j] * scale_[j], info.lower, info.upper);
  }
}

SkinPoint PointAt(const ParameterMaps& maps, std::size_t pixel, double base_absorbance) {
  SkinPoint p;
  for (int i = 0; i < kParameterCount; ++i) p[i] = maps.planes[i].data()[pixel];
  p[kParameterCount] =
      maps.junction_absorbance.empty() ? base_absorbance : maps.junction_absorbance[0].data()[pixel];
  return p;
}

void SetPointAt(ParameterMaps& maps, std::size_t pixel, const SkinPoint& p) {
  for (int i = 0; i < kParameterCount; ++i) maps.planes[i].data()[pixel] = static_cast<float>(p[i]);
  if (maps.junction_absorbance.size() == 1)
    maps.junction_absorbance[0].data()[pixel] = static_cast<float>(p[kParameterCount]);
}

}  // namespace dermap
