// SPDX-License-Identifier: Apache-2.0
// The physiological parameters of [D08 table 1], their bounds and the prior means of average skin.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/image.h"

namespace dermap {

enum class Parameter { kC_m = 0, kBeta_m, kC_he, kC_bc, kC_hd, kJunctionAbsorbance };
inline constexpr int kParameterCount = 5;  // of [D08 table 1]; the junction's absorbance is not in it

struct ParameterInfo {
  std::string_view name;         // channel name in maps.exr
  std::string_view description;  // for people
  std::string_view unit;
  double lower;  // [D08 table 1]
  double upper;
  double mean;  // average skin: prior mean, and the value of whatever is not free
};

inline constexpr std::array<ParameterInfo, kParameterCount> kParameters{{
    {"C_m", "melanin", "volume fraction", 0.0, 0.5, 0.06},
    {"beta_m", "eumelanin share of melanin", "fraction", 0.0, 1.0, 0.62},
    {"C_he", "blood in the epidermis", "volume fraction at 150 g/L", 0.0, 0.05, 0.005},
    {"C_bc", "carotene", "g/L", 0.0, 0.05, 0.01},
    {"C_hd", "blood in the dermis", "volume fraction at 150 g/L", 0.0, 0.1, 0.03},
}};

// What a fit may free: table 1, and the junction's absorbance (P of [D08 eq. 8], gray).
inline constexpr int kUnknownCount = kParameterCount + 1;
// Up to 3: a twentieth of the light crosses once, and of what lies below nothing is seen. The mean is the
// base value of [D08 5.3].
inline constexpr ParameterInfo kJunctionInfo{
    "junction_absorbance", "absorbance at the junction", "absorbance (base e)", 0.0, 3.0, 0.0175};
constexpr const ParameterInfo& InfoOf(Parameter p) {
  return p == Parameter::kJunctionAbsorbance ? kJunctionInfo : kParameters[static_cast<int>(p)];
}

// nullopt for a name that is not in table 1.
std::optional<Parameter> ParameterFromName(std::string_view name);

using ParameterVector = std::array<double, kParameterCount>;  // indexed by Parameter
ParameterVector AverageSkin();

// One plane a parameter, all of one shape. `junction_absorbance` is the total P of [D08 eq. 8]: empty (the
// configuration's base value everywhere), one gray plane, or one plane a band (inks).
struct ParameterMaps {
  std::array<PlaneF, kParameterCount> planes;
  std::vector<PlaneF> junction_absorbance;

  ParameterMaps() = default;
  ParameterMaps(int width, int height, const ParameterVector& value);
  int width() const { return planes[0].width(); }
  int height() const { return planes[0].height(); }
  PlaneF& operator[](Parameter p) { return planes[static_cast<int>(p)]; }
  const PlaneF& operator[](Parameter p) const { return planes[static_cast<int>(p)]; }
  // Any unknown's plane: the junction's is the gray one, which must be there.
  PlaneF& Unknown(Parameter p) {
    return p == Parameter::kJunctionAbsorbance ? junction_absorbance[0] : planes[static_cast<int>(p)];
  }
  const PlaneF& Unknown(Parameter p) const {
    return p == Parameter::kJunctionAbsorbance ? junction_absorbance[0] : planes[static_cast<int>(p)];
  }
};

}  // namespace dermap
