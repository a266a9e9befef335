// SPDX-License-Identifier: Apache-2.0
// Unit vectors of an edge.
#include "calibrate/edge.h"

#include <cmath>

namespace dermap {

double Edge::length() const {
  return std::hypot(to.x - from.x, to.y - from.y);
}
Point Edge::along() const {
  return {(to.x - from.x) / length(), (to.y - from.y) / length()};
}
Point Edge::inwards() const {
  return {-along().y, along().x};
}
Point Edge::At(double t, double s) const {
  const Point a = along();
  return {from.x + t * a.x - s * a.y, from.y + t * a.y + s * a.x};
}

}  // namespace dermap
