// SPDX-License-Identifier: Apache-2.0
// The derivatives use that exp(b^2 / (2 l^2) - d / l) phi(d / b - b / l) is phi(d / b).
#include "calibrate/edge_loss.h"

#include <cmath>

namespace dermap {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kWholly = 6.0;  // standard deviations; 1e-9 of a Gaussian lies beyond
constexpr double kBeyond = 7.0;  // 1e-12

}  // namespace

double NormalIntegral(double z) {
  return 0.5 * std::erfc(-z / std::sqrt(2.0));
}

double NormalDensity(double z) {
  return std::exp(-0.5 * z * z) / std::sqrt(2.0 * kPi);
}

EdgeLoss BlurredLoss(double d, double length, double blur) {
  if (d < -kBeyond * blur) return {};
  const double ratio = blur / length;
  const double z = d / blur - ratio;
  const double inside = z > kWholly ? 1.0 : NormalIntegral(z);
  const double loss = inside > 0.0 ? 0.5 * std::exp(0.5 * ratio * ratio - d / length) * inside : 0.0;
  const double bell = d > kBeyond * blur ? 0.0 : 0.5 * NormalDensity(d / blur) / blur;
  return {loss, bell - loss / length, ratio / length * loss - bell * (d / blur + ratio)};
}

}  // namespace dermap
