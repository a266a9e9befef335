// SPDX-License-Identifier: Apache-2.0
// Scaled free parameters.
#include "fit/parameter_space.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dermap {

ParameterSpace::ParameterSpace(std::vector<Parameter> free) : free_(std::move(free)) {
  for (int j = 0; j < count(); ++j) {
    const ParameterInfo& info = kParameters[static_cast<int>(free_[j])];
    scale_[j] = (info.upper - info.lower) / std::sqrt(12.0);
    lower_[j] = info.lower / scale_[j];
    upper_[j] = info.upper / scale_[j];
    mean_[j] = info.mean / scale_[j];
  }
}

FreeVector ParameterSpace::FromParameters(const ParameterVector& p) const {
  FreeVector u{};
  for (int j = 0; j < count(); ++j) u[j] = p[static_cast<int>(free_[j])] / scale_[j];
  return u;
}

void ParameterSpace::ToParameters(const FreeVector& u, ParameterVector& p) const {
  for (int j = 0; j < count(); ++j) {
    const ParameterInfo& info = kParameters[static_cast<int>(free_[j])];
    p[static_cast<int>(free_[j])] = std::clamp(u[j] * scale_[j], info.lower, info.upper);
  }
}

ParameterVector ParametersAt(const ParameterMaps& maps, std::size_t pixel) {
  ParameterVector p;
  for (int i = 0; i < kParameterCount; ++i) p[i] = maps.planes[i].data()[pixel];
  return p;
}

void SetParametersAt(ParameterMaps& maps, std::size_t pixel, const ParameterVector& p) {
  for (int i = 0; i < kParameterCount; ++i) maps.planes[i].data()[pixel] = static_cast<float>(p[i]);
}

}  // namespace dermap
