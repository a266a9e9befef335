// SPDX-License-Identifier: Apache-2.0
// Normal equations of the four edges: a few parameters that all samples share, and levels of a stretch of an
// edge, which meet the shared ones only. Stretches are eliminated one by one, a hundred times faster than the
// whole matrix.
#pragma once

#include <array>
#include <vector>

namespace dermap {

struct EdgeNormal {
  static constexpr int kShared = 11;
  static constexpr int kOwn = 4;  // a stretch
  using Shared = std::array<double, kShared>;
  using Own = std::array<double, kOwn>;

  struct Stretch {
    std::array<Own, kOwn> own{};       // lower triangle
    std::array<Shared, kOwn> cross{};  // own by shared
    Own right{};
  };
  std::array<Shared, kShared> shared{};  // lower triangle
  Shared right{};
  std::vector<Stretch> stretches;
};

struct EdgeStep {
  EdgeNormal::Shared shared{};
  std::vector<EdgeNormal::Own> own;  // of each stretch
};
EdgeStep Solve(const EdgeNormal& normal);

// direction^T C direction, C the inverse of the normal matrix.
double VarianceAlong(const EdgeNormal& normal, const EdgeNormal::Shared& direction);

}  // namespace dermap
