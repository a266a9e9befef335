// SPDX-License-Identifier: Apache-2.0
// Pairs of runs.
#include "studies/paired_time.h"

#include <algorithm>
#include <chrono>
#include <vector>

namespace dermap {
namespace {

double SecondsOf(const std::function<void()>& run) {
  const auto begin = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

}  // namespace

PairedTime TimePaired(const std::function<void()>& yardstick, const std::function<void()>& run,
                      double budget_s) {
  constexpr std::size_t kMost = 15;
  constexpr double kSlow_s = 1.0, kVerySlow_s = 10.0;
  std::vector<double> seconds, ratios;
  double used = 0.0;
  const auto pair = [&](double first, double second) {
    seconds.push_back(second);
    ratios.push_back(second / std::max(first, 1e-9));
    used += first + second;
  };
  std::size_t fewest = 1;
  if (budget_s > 0.0) {
    yardstick();
    const double warm_up = SecondsOf(run);
    if (warm_up > kSlow_s) pair(SecondsOf(yardstick), warm_up);
    fewest = warm_up > kVerySlow_s ? 2 : 3;
  }
  while (ratios.size() < fewest || (used < budget_s && ratios.size() < kMost)) {
    const double first = SecondsOf(yardstick);
    pair(first, SecondsOf(run));
  }
  PairedTime time;
  time.pairs = static_cast<int>(ratios.size());
  time.seconds = Quantile(seconds, 0.5);
  time.ratio = Quantile(ratios, 0.5);
  time.ratio_spread = 0.5 * (Quantile(ratios, 0.75) - Quantile(ratios, 0.25)) / time.ratio;
  return time;
}

}  // namespace dermap
