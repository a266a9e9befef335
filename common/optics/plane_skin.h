// SPDX-License-Identifier: Apache-2.0
// Totals of homogeneous skin from every direction of light, nothing assumed about directions: discrete
// ordinates of each layer, added with their faces.
#pragma once

#include "common/optics/discrete_ordinates.h"
#include "common/tissue/tissue.h"

namespace dermap {

// The media of a skin: outside, epidermis, dermis; thin parts have epidermis and outside again below.
class PlaneSkin {
 public:
  // Refractive indices and anisotropy g; scattering coefficients below are reduced ones, and the real ones
  // are mu_s' / (1 - g).
  explicit PlaneSkin(const TissueConfig& config);

  // The epidermis and the skin's surface above it, without its lower face; and the dermis without its upper
  // one.
  LightOperators Epidermis(double mu_a, double mu_s_reduced, double thickness_mm) const;
  LightOperators Dermis(double mu_a, double mu_s_reduced,
                        double thickness_mm = std::numeric_limits<double>::infinity()) const;

  struct Light {
    double reflectance, transmittance;  // specular reflection of the surface left out
  };
  // Light along the normal from outside.
  Light EpidermisAlone(const LightOperators& epidermis) const;  // its lower face against the dermis
  Light TwoLayers(const LightOperators& epidermis, const LightOperators& dermis,
                  double junction_absorbance) const;
  // Epidermis, thin dermis, the same epidermis turned over, outside; absorbers at both junctions. The same
  // from above and from below.
  Light ThinPart(const LightOperators& epidermis, const LightOperators& dermis,
                 double junction_absorbance) const;
  // Of Lambertian light in the epidermis, per light that crosses into the dermis: what crosses back.
  double DermisAlone(const LightOperators& dermis) const;
  // Part of TwoLayers' reflectance that was scattered exactly once, in closed form; what the junction mirrors
  // (5e-5) is left out.
  double SingleScattering(double mu_a_epidermis, double mu_s_reduced_epidermis, double thickness_mm,
                          double mu_a_dermis, double mu_s_reduced_dermis, double junction_absorbance) const;

 private:
  double anisotropy_;
  AngularGrid grid_;
  LightOperators surface_, junction_;
  double specular_;

  double RealScattering(double mu_s_reduced) const { return mu_s_reduced / (1.0 - anisotropy_); }
};

}  // namespace dermap
