// SPDX-License-Identifier: Apache-2.0
// Drawing features with soft edges.
#include "acquire/simulated/skin_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "acquire/simulated/random_field.h"

namespace dermap {
namespace {

// 1 well inside (distance << 0), 0 well outside, smooth over `edge_mm` around 0.
double SoftInside(double distance_mm, double edge_mm) {
  const double t = std::clamp(0.5 - distance_mm / edge_mm, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

struct Freckle {
  Point_mm center;
  double radius_mm;
  double strength;             // 0.6 to 1
  double wobble[3], phase[3];  // of the outline: relative amplitudes of 2, 3 and 4 lobes
};

Freckle DrawOne(std::mt19937_64& random, double side_mm, const FreckleField& field) {
  Freckle f;
  f.center = {side_mm * Uniform(random), side_mm * Uniform(random)};
  f.radius_mm =
      field.smallest_radius_mm + (field.largest_radius_mm - field.smallest_radius_mm) * Uniform(random);
  f.strength = 0.6 + 0.4 * Uniform(random);
  for (int i = 0; i < 3; ++i) {
    f.wobble[i] = 0.12 * (2.0 * Uniform(random) - 1.0);
    f.phase[i] = 2.0 * std::numbers::pi * Uniform(random);
  }
  return f;
}

double Coverage(const Freckle& f, double x_mm, double y_mm, double edge_mm) {
  const double dx = x_mm - f.center.x, dy = y_mm - f.center.y;
  const double r = std::hypot(dx, dy);
  if (r > 1.4 * f.radius_mm + edge_mm) return 0.0;
  const double angle = std::atan2(dy, dx);
  double radius = 1.0;
  for (int i = 0; i < 3; ++i) radius += f.wobble[i] * std::cos((i + 2) * angle + f.phase[i]);
  return f.strength * SoftInside(r - radius * f.radius_mm, edge_mm);
}

double DistanceToSegment(Point_mm p, Point_mm a, Point_mm b) {
  const double ux = b.x - a.x, uy = b.y - a.y;
  const double length2 = ux * ux + uy * uy;
  const double t =
      length2 > 0.0 ? std::clamp(((p.x - a.x) * ux + (p.y - a.y) * uy) / length2, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - t * ux, p.y - a.y - t * uy);
}

// Catmull-Rom through the points, so that a vein has no corners.
std::vector<Point_mm> Smoothed(const std::vector<Point_mm>& points) {
  constexpr int kSteps = 16;
  const int n = static_cast<int>(points.size());
  const auto at = [&](int i) { return points[static_cast<std::size_t>(std::clamp(i, 0, n - 1))]; };
  std::vector<Point_mm> curve;
  for (int i = 0; i + 1 < n; ++i) {
    const Point_mm a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
    for (int s = 0; s < kSteps; ++s) {
      const double t = static_cast<double>(s) / kSteps;
      const auto blend = [t](double p0, double p1, double p2, double p3) {
        return 0.5 *
               (2.0 * p1 +
                t * (p2 - p0 + t * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3 + t * (3.0 * (p1 - p2) + p3 - p0))));
      };
      curve.push_back({blend(a.x, b.x, c.x, d.x), blend(a.y, b.y, c.y, d.y)});
    }
  }
  curve.push_back(points.back());
  return curve;
}

}  // namespace

void DrawVariation(PlaneF& plane, double pixel_size_mm, const Variation& variation, std::uint64_t seed,
                   int index) {
  const RandomField field(RandomStream(seed, "variation", static_cast<std::uint64_t>(index)),
                          variation.correlation_mm);
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      const double wave =
          variation.amplitude == 0.0 ? 0.0 : field.At((x + 0.5) * pixel_size_mm, (y + 0.5) * pixel_size_mm);
      plane(x, y) = static_cast<float>(variation.value + variation.amplitude * wave);
    }
  }
}

void DrawFreckles(ParameterMaps& maps, double pixel_size_mm, const FreckleField& field, std::uint64_t seed,
                  int index) {
  auto random = RandomStream(seed, "freckles", static_cast<std::uint64_t>(index));
  std::vector<Freckle> freckles;
  for (int i = 0; i < field.count; ++i)
    freckles.push_back(DrawOne(random, maps.width() * pixel_size_mm, field));
  for (int y = 0; y < maps.height(); ++y) {
    for (int x = 0; x < maps.width(); ++x) {
      double clear = 1.0;  // freckles that overlap do not add up beyond one
      for (const Freckle& f : freckles) {
        clear *= 1.0 - Coverage(f, (x + 0.5) * pixel_size_mm, (y + 0.5) * pixel_size_mm, field.edge_mm);
      }
      maps[Parameter::kC_m](x, y) += static_cast<float>(field.C_m * (1.0 - clear));
      maps[Parameter::kBeta_m](x, y) += static_cast<float>(field.beta_m * (1.0 - clear));
    }
  }
}

void DrawLine(PlaneF& added, double pixel_size_mm, const SoftLine& line) {
  const std::vector<Point_mm> curve = Smoothed(line.points);
  for (int y = 0; y < added.height(); ++y) {
    for (int x = 0; x < added.width(); ++x) {
      const Point_mm p{(x + 0.5) * pixel_size_mm, (y + 0.5) * pixel_size_mm};
      double distance = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
        distance = std::min(distance, DistanceToSegment(p, curve[i], curve[i + 1]));
      }
      const auto here =
          static_cast<float>(line.amount * SoftInside(distance - 0.5 * line.width_mm, line.edge_mm));
      if (std::abs(here) > std::abs(added(x, y))) added(x, y) = here;
    }
  }
}

void ClampToBounds(ParameterMaps& maps) {
  for (int k = 0; k < kParameterCount; ++k) {
    const auto lower = static_cast<float>(kParameters[static_cast<std::size_t>(k)].lower);
    const auto upper = static_cast<float>(kParameters[static_cast<std::size_t>(k)].upper);
    for (float& v : maps.planes[static_cast<std::size_t>(k)].values()) v = std::clamp(v, lower, upper);
  }
}

}  // namespace dermap
