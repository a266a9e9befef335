// SPDX-License-Identifier: Apache-2.0
// Modes of the warp and the lens's polynomial.
#include "calibrate/patch_map.h"

#include <cmath>

namespace dermap {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kNewtonSteps = 6;

}  // namespace

std::array<double, Warp::kModes> Warp::Modes(Point unit) {
  const double sx = std::sin(kPi * unit.x), sy = std::sin(kPi * unit.y);
  return {1.0,
          2.0 * unit.x - 1.0,
          2.0 * unit.y - 1.0,
          sx * sy,
          2.0 * sx * std::cos(kPi * unit.x) * sy,
          sx * 2.0 * sy * std::cos(kPi * unit.y)};
}

Point Warp::Of(const std::array<double, kModes>& modes) const {
  Point d;
  for (std::size_t i = 0; i < kModes; ++i) {
    d.x += p[i] * modes[i];
    d.y += p[kModes + i] * modes[i];
  }
  return d;
}

Point Lens::PhotositesFromIdeal(Point p) const {
  if (k1 == 0.0 && k2 == 0.0) return p;
  const double x = (p.x - center_x) / half_diagonal, y = (p.y - center_y) / half_diagonal;
  const double r2 = x * x + y * y;
  const double bend = k1 * r2 + k2 * r2 * r2;
  return {p.x + bend * (p.x - center_x), p.y + bend * (p.y - center_y)};
}

Point Lens::IdealFromPhotosites(Point p) const {
  if (k1 == 0.0 && k2 == 0.0) return p;
  const double r = std::hypot(p.x - center_x, p.y - center_y) / half_diagonal;
  if (r == 0.0) return p;
  double ideal = r;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const double r2 = ideal * ideal;
    ideal -= (ideal * (1.0 + k1 * r2 + k2 * r2 * r2) - r) / (1.0 + 3.0 * k1 * r2 + 5.0 * k2 * r2 * r2);
  }
  return {center_x + ideal / r * (p.x - center_x), center_y + ideal / r * (p.y - center_y)};
}

}  // namespace dermap
