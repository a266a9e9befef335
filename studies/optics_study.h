// SPDX-License-Identifier: Apache-2.0
// How wrong the optics are over mu_a, against two judges; what a forward peak of scattering changes; and how
// much of the reflectance was scattered only once, which crossed polarizers may take out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/core/progress.h"
#include "studies/verdict.h"

namespace dermap {

struct OpticsStudyOptions {
  bool quick = false;  // few points and photons: for tests
  std::uint64_t seed = 1;
};

struct JudgedValue {
  double value = 0.0, standard_error = 0.0;
};

// One homogeneous two-layer skin; reflectances as docs/formats.md defines them, isotropic unless said
// otherwise.
struct OpticsPoint {
  double wavelength_nm = 0.0, mu_a_epidermis = 0.0, mu_a_dermis = 0.0, junction_absorbance = 0.0;
  double adding_doubling = 0.0;
  double exact = 0.0;         // row by row, as `dermap optics`
  double exact_tables = 0.0;  // from responses with typical neighbours, as tables for fits are made of
  double multipole = 0.0, multipole_symmetric = 0.0;
};

// The skins of the curves: one wavelength and dermis, mu_a of the epidermis varies.
struct OpticsCurvePoint {
  OpticsPoint isotropic;
  JudgedValue monte_carlo;
  JudgedValue monte_carlo_single;  // scattered exactly once
  double single = 0.0;             // likewise, by the exact optics
  // Henyey-Greenstein at the same mu_s'.
  double peaked_adding_doubling = 0.0, peaked_exact = 0.0, peaked_single = 0.0;
  JudgedValue peaked_monte_carlo;
};

struct OpticsStudy {
  double anisotropy = 0.8;
  std::uint64_t photons = 0, peaked_photons = 0, seed = 0;
  double curve_wavelength_nm = 550.0, curve_mu_a_dermis = 0.3, curve_junction_absorbance = 0.0175;
  std::vector<OpticsCurvePoint> curve;
  std::vector<OpticsPoint> sweep;  // over wavelengths, both layers and junctions
  std::vector<Verdict> verdicts;
};

OpticsStudy RunOpticsStudy(const OpticsStudyOptions& options, const ProgressFunction& progress);

// optics.csv, optics.json, optics.svg and optics.html; together or not at all.
void WriteOpticsStudy(const std::filesystem::path& folder, const OpticsStudy& study);

}  // namespace dermap
