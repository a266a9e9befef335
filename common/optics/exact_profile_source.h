// SPDX-License-Identifier: Apache-2.0
// The "exact" profiles: every response from the integral equation of exact_layer.h, light that crosses the
// epidermis unscattered kept apart from what is diffuse. Right to Monte Carlo; [D08] uses the multipole
// instead.
#pragma once

#include "common/optics/profile_source.h"

namespace dermap {

class ExactProfileSource : public ProfileSource {
 public:
  std::string_view Name() const override { return "exact"; }
  bool IsCostly() const override { return true; }
  EpidermisTransforms Epidermis(const EpidermisOptics& optics,
                                std::span<const double> k_per_mm) const override;
  DermisTransforms Dermis(const DermisOptics& optics, std::span<const double> k_per_mm) const override;
};

}  // namespace dermap
