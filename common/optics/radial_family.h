// SPDX-License-Identifier: Apache-2.0
// Transforms of many skins that differ in absorption and in how much they scatter, interpolated between few
// that are solved: what makes R(r) of long tables quick.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/optics/homogeneous_skin.h"
#include "common/optics/profile_source.h"

namespace dermap {

class RadialFamily {
 public:
  // nullptr where the rows are too few to be worth it, or no family: they must share the epidermis's
  // thickness and the ratio of the layers' scattering (as wavelengths do), or have few distinct scatterings.
  static std::unique_ptr<const RadialFamily> Of(std::span<const SkinRow> rows, const ProfileSource& source,
                                                const TissueConfig& config);
  ~RadialFamily();

  bool Holds(const SkinRow& row) const;  // else it has to be solved by itself
  std::span<const double> k_per_mm() const { return k_per_mm_; }
  struct Transforms {
    EpidermisTransforms epidermis;
    DermisTransforms dermis;
  };
  Transforms At(const SkinRow& row) const;

 private:
  // Solved at a few scatterings, and at each for a few absorptions of the neighbour that diffuse light comes
  // from.
  struct Node;
  RadialFamily() = default;
  std::vector<double> k_per_mm_;
  std::vector<double> log_scattering_;              // of the epidermis
  std::vector<double> log_neighbour_;               // mu_a of either neighbour
  std::vector<std::unique_ptr<const Node>> nodes_;  // [scattering][neighbour]
  double min_mu_a_ = 0.0, max_mu_a_ = 0.0;
};

}  // namespace dermap
