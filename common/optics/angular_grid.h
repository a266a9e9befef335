// SPDX-License-Identifier: Apache-2.0
// Directions of light in a stack of plane media: cones of constant n sin(theta), so that Snell's law maps
// node onto node and a smooth face is a diagonal.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace dermap {

// Medium m carries only its first mu[m].size() nodes; node 0 is the normal. Weights of d mu sum to 1 in each
// medium.
struct AngularGrid {
  std::vector<double> n;  // of each medium, from the top
  std::vector<Eigen::VectorXd> mu, weight;

  int Size(int medium) const { return static_cast<int>(mu[medium].size()); }
};

// nodes_per_interval: between the critical angles, each of which ends an interval.
AngularGrid MakeAngularGrid(std::span<const double> indices, int nodes_per_interval = 8);

}  // namespace dermap
