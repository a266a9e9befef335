// SPDX-License-Identifier: Apache-2.0
// Gauss-Legendre and Gauss-Radau rules for the adding-doubling judge (Golub and Welsch 1969).
#pragma once

#include <vector>

namespace dermap::reference {

struct Rule {
  std::vector<double> nodes;  // ascending
  std::vector<double> weights;
};

// On [a, b], exact for polynomials up to degree 2n-1.
Rule GaussLegendre(int n, double a, double b);
// On [a, b] with b as a node, exact up to degree 2n-2.
Rule GaussRadauRight(int n, double a, double b);

}  // namespace dermap::reference
