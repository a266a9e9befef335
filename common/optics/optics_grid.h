// SPDX-License-Identifier: Apache-2.0
// A table of homogeneous skins, row by row: total reflectance, the layers' own responses, R(r). What `dermap
// optics` computes; reading and writing CSV is part of it, opening files is not.
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "common/optics/profile_source.h"
#include "common/tissue/tissue.h"

namespace dermap {

struct OpticsRow {
  double wavelength_nm = 0.0;
  double mu_a_epidermis = 0.0, mu_a_dermis = 0.0;                  // 1/mm
  double mu_s_reduced_epidermis = 0.0, mu_s_reduced_dermis = 0.0;  // 1/mm
  double epidermis_thickness_mm = 0.0;
  double junction_absorbance = 0.0;  // P [D08 eq. 8]
};

struct OpticsResult {
  double reflectance = 0.0;    // two layers, normal incidence, without the specular part
  double r1 = 0.0, t1 = 0.0;   // epidermis alone on the dermis's index, normal incidence from outside
  double r2 = 0.0;             // dermis alone, diffuse light that has crossed the junction
  std::vector<double> radial;  // R(r) of the two layers, 1/mm^2
};

// One line a row, '#' lines and empty ones skipped; the first other line names the columns (DESIGN:
// wavelength_nm, mu_a_epidermis_per_mm, mu_a_dermis_per_mm, and optionally junction_absorbance,
// mu_s_reduced_epidermis_per_mm, mu_s_reduced_dermis_per_mm, epidermis_thickness_mm). What a column does not
// say follows from `config`. Throws InputError naming `name` and the line.
std::vector<OpticsRow> ReadOpticsGrid(std::istream& in, const std::string& name, const TissueConfig& config);

// In parallel. Each row is solved for itself, with its own two layers as each other's neighbours.
std::vector<OpticsResult> EvaluateOpticsGrid(const ProfileSource& source, const TissueConfig& config,
                                             std::span<const OpticsRow> rows,
                                             std::span<const double> radii_mm);

// All columns of a row, then reflectance, R1, T1, R2 and R(radius) for each radius.
void WriteOpticsGrid(std::ostream& out, std::span<const OpticsRow> rows,
                     std::span<const OpticsResult> results, std::span<const double> radii_mm);

}  // namespace dermap
