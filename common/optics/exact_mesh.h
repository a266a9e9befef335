// SPDX-License-Identifier: Apache-2.0
// Piecewise Legendre polynomials in optical depth, and their exact moments against exponentials: the basis in
// which the integral equation of exact_layer.h is solved.
#pragma once

#include <array>
#include <complex>
#include <vector>

namespace dermap {

inline constexpr int kElementModes = 4;  // polynomials of degree 0 to 3 in each element, orthonormal

struct DepthMesh {
  std::vector<double> edges;  // optical depth, ascending from 0

  int ElementCount() const { return static_cast<int>(edges.size()) - 1; }
  int Size() const { return ElementCount() * kElementModes; }
  double Thickness() const { return edges.back(); }
  double Height(int element) const { return edges[element + 1] - edges[element]; }
};

// Elements that grow by `ratio` from `smallest` at the upper face (and, if `both_ends`, at the lower one) up
// to `largest`.
struct MeshGrading {
  double smallest, ratio, largest;
};
DepthMesh MakeDepthMesh(double thickness, const MeshGrading& grading, bool both_ends);

// int_0^h P_i(x) exp(-rate x) dx for the orthonormal P_i of an element of height h (real part of rate >= 0),
// and exp(-rate h). From the other end, exp(-rate (h - x)), the odd moments change sign.
template <class T>
struct ExponentialMoments {
  std::array<T, kElementModes> values;
  T fall;
};
ExponentialMoments<double> MomentsOfExponential(double rate, double height);
ExponentialMoments<std::complex<double>> MomentsOfExponential(std::complex<double> rate, double height);

// int_0^h int_0^h P_i(x) P_j(y) exp(-rate |x - y|) dx dy, row by row; `moments` are
// MomentsOfExponential(rate, height).
using SelfMoments = std::array<double, kElementModes * kElementModes>;
SelfMoments SelfMomentsOfExponential(double rate, double height, const ExponentialMoments<double>& moments);

}  // namespace dermap
