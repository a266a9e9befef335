// SPDX-License-Identifier: Apache-2.0
// The words of the command line as fit options.
#include "fit/options.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/core/error.h"

namespace dermap {
namespace {

template <class T, std::size_t N>
using Names = std::array<std::pair<std::string_view, T>, N>;

constexpr Names<FitMethod, 3> kMethods{
    {{"fast", FitMethod::kFast}, {"descent", FitMethod::kDescent}, {"ceres", FitMethod::kCeres}}};
constexpr Names<DescentMetric, 2> kMetrics{
    {{"curvature", DescentMetric::kCurvature}, {"plain", DescentMetric::kPlain}}};
constexpr Names<StartPoint, 3> kStarts{
    {{"average", StartPoint::kAverage}, {"local", StartPoint::kLocal}, {"random", StartPoint::kRandom}}};

template <class T, std::size_t N>
T FromName(const Names<T, N>& names, std::string_view what, std::string_view name) {
  std::string known;
  for (const auto& [candidate, value] : names) {
    if (candidate == name) return value;
    known += (known.empty() ? "" : ", ") + std::string(candidate);
  }
  throw InputError("Unknown " + std::string(what) + " '" + std::string(name) + "'; available: " + known +
                   ".");
}

template <class T, std::size_t N>
std::string_view ToName(const Names<T, N>& names, T value) {
  for (const auto& [name, candidate] : names)
    if (candidate == value) return name;
  return "?";
}

}  // namespace

FitMethod FitMethodFromName(std::string_view name) {
  return FromName(kMethods, "fit method", name);
}
DescentMetric DescentMetricFromName(std::string_view name) {
  return FromName(kMetrics, "descent metric", name);
}
StartPoint StartPointFromName(std::string_view name) {
  return FromName(kStarts, "start of the fit", name);
}

std::string_view NameOf(FitMethod method) {
  return ToName(kMethods, method);
}
std::string_view NameOf(DescentMetric metric) {
  return ToName(kMetrics, metric);
}
std::string_view NameOf(StartPoint start) {
  return ToName(kStarts, start);
}

std::vector<Parameter> FreeParametersFromText(std::string_view text) {
  std::vector<Parameter> free;
  if (text == "auto") return free;
  const std::string known = "C_m, beta_m, C_he, C_bc, C_hd, junction_absorbance (or auto)";
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view name = text.substr(begin, end - begin);
    auto parameter = ParameterFromName(name);
    if (name == kJunctionInfo.name) parameter = Parameter::kJunctionAbsorbance;
    if (!parameter)
      throw InputError("Unknown free parameter '" + std::string(name) + "' in '" + std::string(text) +
                       "'; known: " + known + ".");
    if (std::find(free.begin(), free.end(), *parameter) != free.end())
      throw InputError("Free parameter '" + std::string(name) + "' is listed twice in '" + std::string(text) +
                       "'; name each once.");
    free.push_back(*parameter);
    begin = end + 1;
  }
  std::sort(free.begin(), free.end());
  return free;
}

}  // namespace dermap
