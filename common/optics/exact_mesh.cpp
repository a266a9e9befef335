// SPDX-License-Identifier: Apache-2.0
// Moments of Legendre polynomials against exponentials are modified spherical Bessel functions of the first
// kind.
#include "common/optics/exact_mesh.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

constexpr double kSeriesBelow = 0.4;  // |z| under which the upward recursion would lose digits

double Magnitude(double z) {
  return std::abs(z);
}
double Magnitude(const std::complex<double>& z) {
  return std::abs(z.real()) + std::abs(z.imag());
}

// exp(-z) i_n(z) for n = 0 .. 3, and fall = exp(-2z).
template <class T>
std::array<T, kElementModes> ScaledBessel(T z, T& fall) {
  std::array<T, kElementModes> b;
  if (Magnitude(z) < kSeriesBelow) {
    // i_n(z) = z^n / (2n+1)!! (1 + (z^2/2)/(2n+3) (1 + (z^2/2)/(2 (2n+5)) (...)))
    const T half_square = 0.5 * z * z;
    T leading = std::exp(-z);
    fall = leading * leading;
    for (int n = 0; n < kElementModes; ++n) {
      T sum = T(1.0);
      for (int k = 5; k >= 1; --k)
        sum = 1.0 + half_square / static_cast<double>(k * (2 * n + 2 * k + 1)) * sum;
      b[n] = leading * sum;
      leading *= z / static_cast<double>(2 * n + 3);
    }
    return b;
  }
  fall = std::exp(-2.0 * z);
  const T inverse = 1.0 / z;
  b[0] = 0.5 * (1.0 - fall) * inverse;
  b[1] = (0.5 * (1.0 + fall) - b[0]) * inverse;
  for (int n = 1; n + 1 < kElementModes; ++n) {
    b[n + 1] = b[n - 1] - static_cast<double>(2 * n + 1) * inverse * b[n];
  }
  return b;
}

template <class T>
ExponentialMoments<T> MomentsOf(T rate, double height) {
  ExponentialMoments<T> m;
  m.values = ScaledBessel(T(0.5 * rate * height), m.fall);
  for (int i = 0; i < kElementModes; ++i)
    m.values[i] *= (i % 2 == 0 ? 1.0 : -1.0) * std::sqrt((2 * i + 1) * height);
  return m;
}

}  // namespace

DepthMesh MakeDepthMesh(double thickness, const MeshGrading& grading, bool both_ends) {
  const double span = both_ends ? 0.5 * thickness : thickness;
  std::vector<double> edges{0.0};
  double height = std::min(grading.smallest, 0.4 * span);
  // A last element that would be a sliver joins the one before.
  while (edges.back() + 1.3 * height < span) {
    edges.push_back(edges.back() + height);
    height = std::min(height * grading.ratio, grading.largest);
  }
  if (both_ends) {
    const std::vector<double> upper = edges;
    for (auto edge = upper.rbegin(); edge != upper.rend(); ++edge) edges.push_back(thickness - *edge);
  } else {
    edges.push_back(thickness);
  }
  return {edges};
}

ExponentialMoments<double> MomentsOfExponential(double rate, double height) {
  return MomentsOf(rate, height);
}
ExponentialMoments<std::complex<double>> MomentsOfExponential(std::complex<double> rate, double height) {
  return MomentsOf(rate, height);
}

SelfMoments SelfMomentsOfExponential(double rate, double height, const ExponentialMoments<double>& moments) {
  // Integrating exp(-rate |x - y|) P_j(y) by parts over y leaves 2 P_j(x) / rate + ... and, at each end, an
  // exponential times b[j] = sum_k (-1)^k P_j^(k)(0) / rate^(k+1). For i >= j only the first polynomial term
  // survives the product with P_i, so that nothing large cancels; the matrix is symmetric, and zero where i +
  // j is odd.
  const double inverse = 1.0 / rate, a = inverse / height, root = 1.0 / std::sqrt(height);
  const std::array<double, kElementModes> b{
      root * inverse, -std::sqrt(3.0) * root * inverse * (1.0 + 2.0 * a),
      std::sqrt(5.0) * root * inverse * (1.0 + a * (6.0 + a * 12.0)),
      -std::sqrt(7.0) * root * inverse * (1.0 + a * (12.0 + a * (60.0 + a * 120.0)))};
  SelfMoments self{};
  for (int i = 0; i < kElementModes; ++i) {
    for (int j = i % 2; j <= i; j += 2) {
      const double value = (i == j ? 2.0 * inverse : 0.0) - 2.0 * moments.values[i] * b[j];
      self[i * kElementModes + j] = self[j * kElementModes + i] = value;
    }
  }
  return self;
}

}  // namespace dermap
