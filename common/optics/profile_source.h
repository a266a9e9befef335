// SPDX-License-Identifier: Apache-2.0
// Where reflectance and transmittance profiles come from: one interface, several sources (multipole, exact,
// ...). A profile is given by its 2-D Fourier transform at lateral frequency k (1/mm, radians); k = 0 is its
// total.
//
// Conventions: "forward" is light travelling down, away from the air. R1+ and T1+ are per light that falls on
// the skin's surface from outside (specular reflection counted as fallen, not as reflected), normal
// incidence. R1-, T1- and R2_diffuse are per light that crosses the junction, diffuse.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dermap {

struct LayerOptics {
  double mu_a = 0.0;          // 1/mm
  double mu_s_reduced = 1.0;  // 1/mm
  double n = 1.4;
  double anisotropy = 0.0;  // g of real scattering, mu_s = mu_s' / (1 - g); sources may know 0 only
};

// The layer from which diffuse light comes, as far as the light's directions depend on it: a typical one
// serves, and is all that tables can know. A source may ignore it.
struct TypicalNeighbour {
  double mu_a = 0.0;          // 1/mm
  double mu_s_reduced = 0.0;  // 1/mm; 0: the dermis scatters half as much as the epidermis [D08 eq. 12]
};

// The epidermis between air (or gel) above and dermis below.
struct EpidermisOptics {
  LayerOptics layer;
  double thickness_mm = 0.25;
  double n_above = 1.0;  // outside
  double n_below = 1.38;
  // Under black tape what reaches the surface from below is absorbed, not reflected internally.
  bool black_above = false;
  TypicalNeighbour dermis{.mu_a = 0.08};
};

// The semi-infinite dermis under the epidermis.
struct DermisOptics {
  LayerOptics layer;
  double n_above = 1.4;
  TypicalNeighbour epidermis{.mu_a = 0.5};
  double epidermis_thickness_mm = 0.25;
};

struct EpidermisTransforms {
  std::vector<double> r_forward;   // R1+
  std::vector<double> t_forward;   // T1+, without its ballistic part where the source separates it
  std::vector<double> r_backward;  // R1-
  std::vector<double> t_backward;  // T1-
  double t_ballistic = 0.0;  // share of the incident light that crosses unscattered (it does not spread)
  std::vector<double>
      r_single;  // part of R1+ that was scattered exactly once; empty if the source does not know
};

struct DermisTransforms {
  std::vector<double> r_diffuse;  // R2 for diffuse light
  std::vector<double> r_normal;   // R2 for ballistic light (normal incidence)
};

class ProfileSource {
 public:
  virtual ~ProfileSource() = default;
  virtual std::string_view Name() const = 0;  // as in --profiles, and part of table cache keys
  virtual EpidermisTransforms Epidermis(const EpidermisOptics& optics,
                                        std::span<const double> k_per_mm) const = 0;
  virtual DermisTransforms Dermis(const DermisOptics& optics, std::span<const double> k_per_mm) const = 0;
  // Whether LayerOptics::anisotropy is honoured.
  virtual bool KnowsAnisotropy() const { return false; }
  // Tables of a costly source are made from few absorptions (sampled_source.h) and kept on disk
  // (table_cache.h).
  virtual bool IsCostly() const { return false; }
};

// "exact" (right to Monte Carlo), "multipole" (the paper's, direction-aware), "multipole-symmetric" (one R1
// and T1 for both directions). Throws InputError that lists the known names.
std::unique_ptr<ProfileSource> MakeProfileSource(std::string_view name);
const std::vector<std::string>& ProfileSourceNames();

}  // namespace dermap
