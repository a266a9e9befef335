// SPDX-License-Identifier: Apache-2.0
// Edits of parameter maps in words: "C_hd*=0.4" shows the patch with 40 % of the blood in its dermis.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/tissue/parameters.h"

namespace dermap {

enum class EditOperation { kSet, kMultiply, kDivide, kAdd, kSubtract };

struct MapEdit {
  std::optional<Parameter> parameter;  // empty: the junction's absorbance
  EditOperation operation = EditOperation::kSet;
  double value = 0.0;
  std::string text;  // as it was written
};

inline constexpr std::string_view kJunctionName = "junction_absorbance";
inline constexpr double kMaxJunctionAbsorbance = 10.0;  // 1 part in 20000 crosses: black

// NAME OP NUMBER with OP one of = *= /= += -=; blanks are ignored. The number has a decimal point and is
// finite. Throws InputError that says what is wrong and lists the known names.
MapEdit ParseEdit(std::string_view text);

// Applies the edit to every pixel and clamps to the bounds of [D08 table 1]. Returns a sentence for people:
// what was done and how many pixels were clamped. `base_junction_absorbance` is what maps without a plane of
// it have everywhere.
std::string ApplyEdit(ParameterMaps& maps, const MapEdit& edit, double base_junction_absorbance);

}  // namespace dermap
