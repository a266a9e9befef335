// SPDX-License-Identifier: Apache-2.0
// The front of a chart of time against error: what nothing else beats in both.
#pragma once

#include <cstddef>
#include <vector>

namespace dermap {

struct TimedError {
  double time = 0.0, error = 0.0;
  double error_bar = 0.0;  // half length, of `error`
};

// Indices of the points that no other is at most as slow and at most as wrong as, by time; of equal ones the
// first. Points whose values are not finite and positive take no part.
std::vector<std::size_t> ParetoFront(const std::vector<TimedError>& points);

// Times within this factor of each other are the same: what a shared machine lets one tell.
inline constexpr double kSameTime = 1.15;

// Whether any other point is faster by more than kSameTime and less wrong by more than the point's error bar.
bool IsDominated(const std::vector<TimedError>& points, std::size_t index);

}  // namespace dermap
