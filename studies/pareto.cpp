// SPDX-License-Identifier: Apache-2.0
// Sorted by time, the front are the points with the least error so far.
#include "studies/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace dermap {
namespace {

bool Counts(const TimedError& p) {
  return std::isfinite(p.time) && std::isfinite(p.error) && p.time > 0.0 && p.error > 0.0;
}

}  // namespace

std::vector<std::size_t> ParetoFront(const std::vector<TimedError>& points) {
  std::vector<std::size_t> order(points.size()), front;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].time != points[b].time ? points[a].time < points[b].time
                                            : points[a].error < points[b].error;
  });
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) {
    if (!Counts(points[i]) || points[i].error >= least) continue;
    least = points[i].error;
    front.push_back(i);
  }
  return front;
}

bool IsDominated(const std::vector<TimedError>& points, std::size_t index) {
  const TimedError& p = points[index];
  return std::any_of(points.begin(), points.end(), [&](const TimedError& other) {
    return Counts(other) && other.time * kSameTime < p.time && other.error < p.error - p.error_bar;
  });
}

}  // namespace dermap
