// SPDX-License-Identifier: Apache-2.0
// The parameters of measured skin: [D08 table 1], and what real spectra may need beyond it.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "common/tissue/tissue.h"

namespace dermap {

enum class SkinParameter {
  kC_m = 0,
  kBeta_m,
  kC_he,
  kC_bc,
  kC_hd,
  kOxygenation,
  kAmplitude,
  kSlope,
  kThickness,
  kVesselRadius,
  kBaseline,
  kSurface,
};
inline constexpr int kSkinParameterCount = 12;

struct SkinParameterInfo {
  std::string_view name;         // column of spectra.csv
  std::string_view description;  // for people
  std::string_view unit;
  double lower, upper;  // physiological range, the bounds of a fit
  double mean;          // where a fit starts, and the value of whatever is not free
};

// Ranges and means of the first five are those of [D08 table 1].
inline constexpr std::array<SkinParameterInfo, kSkinParameterCount> kSkinParameters{{
    {"C_m", "melanin in the epidermis", "volume fraction", 0.0, 0.5, 0.06},
    {"beta_m", "eumelanin share of melanin", "fraction", 0.0, 1.0, 0.62},
    {"C_he", "blood of capillaries near the surface", "volume fraction at 150 g/L", 0.0, 0.05, 0.005},
    {"C_bc", "carotene", "g/L", 0.0, 0.05, 0.01},
    {"C_hd", "blood in the dermis", "volume fraction at 150 g/L", 0.0, 0.1, 0.03},
    {"oxygenation", "share of oxyhemoglobin", "fraction", 0.0, 1.0, 0.75},
    {"scattering_amplitude", "factor on the published scattering", "1", 0.3, 3.0, 1.0},
    {"scattering_slope", "extra exponent of scattering", "1", -1.5, 1.5, 0.0},
    {"epidermis_thickness_mm", "thickness of the epidermis", "mm", 0.03, 0.3, 0.06},
    {"vessel_radius_mm", "radius of the vessels that hold the dermis's blood", "mm", 0.0, 0.1, 0.0},
    {"baseline", "factor on the absorption of bloodless, melanin-free tissue", "1", 0.5, 2.0, 1.0},
    {"surface_reflectance", "light that the skin's surface adds", "fraction", 0.0, 0.06, 0.0},
}};

// The tissue that real spectra are compared with: an epidermis of 0.06 mm [Sandby-Moller, Poulsen, Wulf 2003:
// 0.057 mm on the forearm], and scattering that points forwards (0.8), which [D08] and maps leave out and
// which lowers the reflectance where absorption is strong.
TissueConfig MeasuredTissue();

using SkinVector = std::array<double, kSkinParameterCount>;  // indexed by SkinParameter

constexpr const SkinParameterInfo& InfoOf(SkinParameter p) {
  return kSkinParameters[static_cast<int>(p)];
}

// A set of free parameters that a spectrum may need; the others stay at `fixed`.
struct SkinModel {
  std::string_view name;
  std::string_view description;
  std::vector<SkinParameter> free;
  SkinVector fixed;
};

// The published formulas, the core that real skin cannot do without, and one or two extensions of it; at most
// 7 parameters are free in any.
// Of `tissue` the thickness, the oxygenation and the scattering are what is not free; [D08]'s own are kept
// for "published".
std::vector<SkinModel> SkinModels(const TissueConfig& tissue);
const std::vector<std::string_view>& SkinModelNames();
// Throws InputError that lists the names.
SkinModel SkinModelFromName(std::string_view name, const TissueConfig& tissue);

}  // namespace dermap
