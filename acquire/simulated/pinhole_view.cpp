// SPDX-License-Identifier: Apache-2.0
// Pinhole projection of a tilted plane.
#include "acquire/simulated/pinhole_view.h"

#include <cmath>
#include <numbers>

namespace dermap {
namespace {

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180.0;
}

}  // namespace

PinholeView::PinholeView(const BenchConfig& config, double view_angle_deg)
    : center_x_px_(config.window_center_px[0]),
      center_y_px_(config.window_center_px[1]),
      focal_px_(config.scale_px_per_mm * config.camera_distance_mm),
      distance_mm_(config.camera_distance_mm),
      sin_(std::sin(Radians(view_angle_deg))),
      cos_(std::cos(Radians(view_angle_deg))) {}

Point2 PinholeView::PixelFromBench(Point2 p) const noexcept {
  const double depth_mm = distance_mm_ + p.y * sin_;
  return {center_x_px_ + focal_px_ * p.x / depth_mm, center_y_px_ + focal_px_ * p.y * cos_ / depth_mm};
}

Point2 PinholeView::BenchFromPixel(Point2 pixel) const noexcept {
  const double a = (pixel.x - center_x_px_) / focal_px_;
  const double b = (pixel.y - center_y_px_) / focal_px_;
  const double y = b * distance_mm_ / (cos_ - b * sin_);
  return {a * (distance_mm_ + y * sin_), y};
}

Point2 BenchFromPatch(const Pose& pose, double window_mm, Point2 patch_mm) noexcept {
  const double c = std::cos(Radians(pose.rotation_deg)), s = std::sin(Radians(pose.rotation_deg));
  const double x = patch_mm.x - 0.5 * window_mm, y = patch_mm.y - 0.5 * window_mm;
  return {c * x - s * y + pose.shift_x_mm, s * x + c * y + pose.shift_y_mm};
}

Point2 PatchFromBench(const Pose& pose, double window_mm, Point2 bench_mm) noexcept {
  const double c = std::cos(Radians(pose.rotation_deg)), s = std::sin(Radians(pose.rotation_deg));
  const double x = bench_mm.x - pose.shift_x_mm, y = bench_mm.y - pose.shift_y_mm;
  return {c * x + s * y + 0.5 * window_mm, -s * x + c * y + 0.5 * window_mm};
}

std::array<Point2, 4> WindowCorners(const PinholeView& view, const Pose& pose, double window_mm) noexcept {
  const auto corner = [&](double x, double y) {
    return view.PixelFromBench(BenchFromPatch(pose, window_mm, {x, y}));
  };
  return {corner(0.0, 0.0), corner(window_mm, 0.0), corner(window_mm, window_mm), corner(0.0, window_mm)};
}

}  // namespace dermap
