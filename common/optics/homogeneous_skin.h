// SPDX-License-Identifier: Apache-2.0
// What homogeneous two-layer skin does with light, one skin a row: totals, the layers' own responses, R(r),
// thin parts. Unlike tables, every row knows both of its layers.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "common/tissue/tissue.h"

namespace dermap {

struct SkinRow {
  double mu_a_epidermis = 0.0, mu_a_dermis = 0.0;  // 1/mm
  double junction_absorbance = 0.0;
  double mu_s_reduced_epidermis = 1.0, mu_s_reduced_dermis = 1.0;  // 1/mm
  double epidermis_thickness_mm = 0.25;
};

// Normal incidence from outside, per light that falls, specular reflection not counted as reflected; `r2` per
// diffuse light that crosses the junction.
struct SkinResponses {
  double reflectance = 0.0;            // of both layers
  double single = 0.0;                 // part of it that was scattered exactly once
  double r1 = 0.0;                     // of the epidermis alone, its lower face against the dermis
  double t1 = 0.0;                     // likewise, with what is ballistic
  double r2 = 0.0;                     // of the dermis alone
  std::vector<double> radial_per_mm2;  // R(r) of both layers for a pencil beam
  // Epidermis, thin dermis, epidermis: everything that leaves above (but the specular) and below.
  double stack_reflectance = 0.0, stack_transmittance = 0.0;
};

struct SkinRequest {
  std::string profiles = "exact";  // as --profiles
  std::vector<double> radii_mm{};  // for R(r), each > 0
  bool single = false;             // whether single scattering is wanted
  double thin_dermis_mm = 0.0;     // 0: no stack is wanted
};

class HomogeneousSkin {
 public:
  // Of `config` the refractive indices and the anisotropy are used. Throws InputError for profiles that are
  // unknown or that cannot honour the configuration.
  HomogeneousSkin(const SkinRequest& request, const TissueConfig& config);
  ~HomogeneousSkin();

  // In parallel; layers that rows share are solved once.
  std::vector<SkinResponses> Evaluate(std::span<const SkinRow> rows, const ProgressFunction& progress) const;

 private:
  class Model;
  class ExactModel;
  class DiffusionModel;
  std::unique_ptr<const Model> model_;
};

}  // namespace dermap
