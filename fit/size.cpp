// SPDX-License-Identifier: Apache-2.0
// Time is renders times pixels times what a pixel was measured to cost.
#include "fit/size.h"

#include <algorithm>
#include <cstdio>

namespace dermap {

double ExpectedRenders(const FitOptions& options, int free_count) {
  // Iterations seen on simulated samples (light, freckled; medium, with a vein), rounded up.
  constexpr double kCurvatureIterations = 30.0, kFastRenders = 20.0, kReferenceIterations = 100.0;
  constexpr double kTranspose = 5.0;  // value and gradient, in renders
  if (options.method == FitMethod::kFast) return kFastRenders;
  const double limit = options.max_iterations;
  if (options.method == FitMethod::kCeres)
    return kFastRenders + std::min(kReferenceIterations, limit) * kTranspose;
  if (options.metric == DescentMetric::kCurvature)
    return std::min(kCurvatureIterations, limit) * (free_count + 2);
  return limit * (free_count + 1);
}

int LargestAffordableSize(int longer_side, double patch_aspect, double seconds_per_pixel, double renders,
                          double time_budget_s, std::vector<std::string>& decisions) {
  std::vector<int> sizes{longer_side};
  for (int size : {256, 128, 64, 32})
    if (size < longer_side) sizes.push_back(size);
  const auto seconds = [&](int size) { return renders * seconds_per_pixel * size * size * patch_aspect; };
  int chosen = sizes.back();
  for (int size : sizes) {
    if (seconds(size) > time_budget_s) continue;
    chosen = size;
    break;
  }
  char text[320];
  if (chosen == longer_side)
    std::snprintf(text, sizeof text, "The fit ran at the stack's full size, %d pixels along the longer side.",
                  chosen);
  else
    std::snprintf(
        text, sizeof text,
        "The fit ran at %d pixels along the longer side instead of the stack's %d: about %.0f renders of "
        "%.3g s each had to stay within %.0f s (--size and --time-budget-s change that).",
        chosen, longer_side, renders, seconds(chosen) / renders, time_budget_s);
  decisions.emplace_back(text);
  return chosen;
}

}  // namespace dermap
