// SPDX-License-Identifier: Apache-2.0
// Robust statistics by selection (nth_element).
#include "calibrate/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace dermap {
namespace {

constexpr double kSigmaOfDeviation = 1.4826;  // 1 / (quantile of the normal distribution at 0.75)
constexpr double kClipSigmas = 4.5;           // 7 in a million of a normal distribution lie beyond

}  // namespace

double Median(std::vector<float> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

RobustScatter MedianAndScatter(std::span<const float> values) {
  std::vector<float> work(values.begin(), values.end());
  RobustScatter result;
  result.median = Median(work);
  for (float& v : work) v = std::abs(v - static_cast<float>(result.median));
  result.sigma = kSigmaOfDeviation * Median(std::move(work));
  return result;
}

double ClippedVariance(std::span<const float> values) {
  // Rounded data can have a median deviation of zero: then only the plain variance is known.
  const double sigma = MedianAndScatter(values).sigma;
  const double limit = sigma > 0.0 ? kClipSigmas * sigma : std::numeric_limits<double>::infinity();
  double sum = 0.0;
  std::size_t count = 0;
  for (const float v : values) {
    if (std::abs(v) > limit) continue;
    sum += static_cast<double>(v) * v;
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace dermap
