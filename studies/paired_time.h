// SPDX-License-Identifier: Apache-2.0
// Times on a machine that others use too: each run beside one of a yardstick, so that what slows one down
// slows the other down as well.
#pragma once

#include <functional>

namespace dermap {

struct PairedTime {
  double seconds = 0.0;       // median
  double ratio = 0.0;         // to the yardstick, median of the pairs
  double ratio_spread = 0.0;  // relative: half the interquartile range of the pairs' ratios over their median
  int pairs = 0;
};

// Both run once beforehand, untimed (caches), unless `run` takes longer than 1 s: then that time counts as
// well. At least 3 pairs, 2 of what takes longer than 10 s; more until `budget_s` is used, 9 at most.
// A budget of 0 means that times do not matter: one pair, caches or not.
PairedTime TimePaired(const std::function<void()>& yardstick, const std::function<void()>& run,
                      double budget_s);

}  // namespace dermap
