// SPDX-License-Identifier: Apache-2.0
// Parses and applies edits of parameter maps.
#include "render/edit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "common/core/error.h"

namespace dermap {
namespace {

constexpr std::array<std::pair<std::string_view, EditOperation>, 5> kOperations{{
    {"*=", EditOperation::kMultiply},
    {"/=", EditOperation::kDivide},
    {"+=", EditOperation::kAdd},
    {"-=", EditOperation::kSubtract},
    {"=", EditOperation::kSet},  // last: it is the end of the others
}};

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string KnownNames() {
  std::string names;
  for (const ParameterInfo& info : kParameters) names += std::string(info.name) + ", ";
  return names.append(kJunctionName);
}

[[noreturn]] void Refuse(std::string_view text, const std::string& reason) {
  throw InputError(
      "The edit '" + std::string(text) + "' " + reason +
      "; write NAME OP NUMBER, such as C_hd*=0.4, with OP one of = *= /= += -= and NAME one of " +
      KnownNames() + ".");
}

double ParseNumber(std::string_view text, std::string_view number) {
  std::string_view digits = number;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-' && digits[1] != '+') digits.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value)) {
    Refuse(text, number.empty() ? "has no number"
                                : "has '" + std::string(number) + "' in place of a finite number");
  }
  return value;
}

struct Bounds {
  double lower, upper;
};

Bounds BoundsOf(const MapEdit& edit) {
  if (!edit.parameter) return {0.0, kMaxJunctionAbsorbance};
  const ParameterInfo& info = kParameters[static_cast<std::size_t>(*edit.parameter)];
  return {info.lower, info.upper};
}

double Apply(const MapEdit& edit, double old) {
  switch (edit.operation) {
    case EditOperation::kSet:
      return edit.value;
    case EditOperation::kMultiply:
      return old * edit.value;
    case EditOperation::kDivide:
      return old / edit.value;
    case EditOperation::kAdd:
      return old + edit.value;
    case EditOperation::kSubtract:
      return old - edit.value;
  }
  return old;
}

}  // namespace

MapEdit ParseEdit(std::string_view text) {
  MapEdit edit;
  edit.text = Trim(text);
  const auto equals = text.find('=');
  if (equals == std::string_view::npos) Refuse(text, "has no operator");
  const std::string_view left = text.substr(0, equals + 1);
  const auto* operation = std::find_if(kOperations.begin(), kOperations.end(),
                                       [&](const auto& known) { return left.ends_with(known.first); });
  edit.operation = operation->second;
  const std::string_view name = Trim(left.substr(0, left.size() - operation->first.size()));
  if (name != kJunctionName) {
    edit.parameter = ParameterFromName(name);
    if (!edit.parameter) {
      Refuse(text, name.empty() ? "names no parameter"
                                : "names '" + std::string(name) + "', which is no parameter");
    }
  }
  edit.value = ParseNumber(text, Trim(text.substr(equals + 1)));
  if (edit.operation == EditOperation::kDivide && edit.value == 0.0) Refuse(text, "divides by 0");
  return edit;
}

std::string ApplyEdit(ParameterMaps& maps, const MapEdit& edit, double base_junction_absorbance) {
  std::vector<PlaneF*> planes;
  if (edit.parameter) {
    planes.push_back(&maps[*edit.parameter]);
  } else {
    auto& junction = maps.junction_absorbance;
    if (junction.empty()) {
      junction.emplace_back(maps.width(), maps.height(), static_cast<float>(base_junction_absorbance));
    }
    for (PlaneF& plane : junction) planes.push_back(&plane);
  }
  const auto [lower, upper] = BoundsOf(edit);
  std::size_t clamped = 0, count = 0;
  for (PlaneF* plane : planes) {
    count += plane->size();
    for (float& value : plane->values()) {
      const double wanted = Apply(edit, value);
      const double kept = std::clamp(wanted, lower, upper);
      clamped += std::abs(kept - wanted) > 1e-6 * upper;  // a float's rounding is no news
      value = static_cast<float>(kept);
    }
  }
  std::string note = "Edited: " + edit.text;
  if (clamped == 0) return note + ".";
  std::array<char, 160> detail{};
  std::snprintf(detail.data(), detail.size(), "; %zu of %zu values were clamped to the bounds %g to %g.",
                clamped, count, lower, upper);
  return note + detail.data();
}

}  // namespace dermap
