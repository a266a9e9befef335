// SPDX-License-Identifier: Apache-2.0
// Robust statistics of samples, and numbers for messages.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace dermap {

double Median(std::vector<float> values);  // NaN for none; values must not be NaN

struct RobustScatter {
  double median = 0.0;
  double sigma =
      0.0;  // 1.4826 times the median absolute deviation: the standard deviation of a normal distribution
};
RobustScatter MedianAndScatter(std::span<const float> values);

// Variance of samples of mean zero, without those beyond 4.5 robust sigmas.
double ClippedVariance(std::span<const float> values);

// At most four significant digits: "0.8", "1.25".
std::string Short(double value);

}  // namespace dermap
