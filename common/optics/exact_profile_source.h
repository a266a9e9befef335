// SPDX-License-Identifier: Apache-2.0
// The "exact" profiles: every response from the integral equation of exact_layer.h, light that crosses the
// epidermis unscattered kept apart from what is diffuse. Right to Monte Carlo; [D08] uses the multipole
// instead.
#pragma once

#include <limits>

#include "common/optics/exact_faces.h"
#include "common/optics/profile_source.h"

namespace dermap {

// What may be saved where less accuracy is wanted than tables have.
struct ExactEffort {
  ExactResolution resolution;
  // An epidermis in which light under lateral structure falls to less than exp(-this) is taken as bottomless:
  // nothing of it reaches the dermis or comes back. Totals (k = 0) are always solved.
  double opaque_beyond = std::numeric_limits<double>::infinity();
};

// The diffuse light that falls into a layer, as its typical neighbour sends it.
ExactNeighbour NeighbourBelow(const EpidermisOptics& optics);
ExactNeighbour NeighbourAbove(const DermisOptics& optics);

class ExactProfileSource : public ProfileSource {
 public:
  explicit ExactProfileSource(const ExactEffort& effort = {}) : effort_(effort) {}

  std::string_view Name() const override { return "exact"; }
  bool IsCostly() const override { return true; }
  // In the totals; the shapes are those of isotropic scattering (anisotropy.h).
  bool KnowsAnisotropy() const override { return true; }
  EpidermisTransforms Epidermis(const EpidermisOptics& optics,
                                std::span<const double> k_per_mm) const override;
  DermisTransforms Dermis(const DermisOptics& optics, std::span<const double> k_per_mm) const override;

 private:
  ExactEffort effort_;
};

}  // namespace dermap
