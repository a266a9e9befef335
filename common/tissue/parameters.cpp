// SPDX-License-Identifier: Apache-2.0
// Look-ups in the table of parameters [D08 table 1].
#include "common/tissue/parameters.h"

namespace dermap {

std::optional<Parameter> ParameterFromName(std::string_view name) {
  for (int i = 0; i < kParameterCount; ++i) {
    if (kParameters[i].name == name) return static_cast<Parameter>(i);
  }
  return std::nullopt;
}

ParameterVector AverageSkin() {
  ParameterVector mean{};
  for (int i = 0; i < kParameterCount; ++i) mean[i] = kParameters[i].mean;
  return mean;
}

ParameterMaps::ParameterMaps(int width, int height, const ParameterVector& value) {
  for (int i = 0; i < kParameterCount; ++i) planes[i] = PlaneF(width, height, static_cast<float>(value[i]));
}

}  // namespace dermap
