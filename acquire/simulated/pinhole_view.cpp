// SPDX-License-Identifier: Apache-2.0
// Pinhole projection of a tilted plane, through a lens that may distort; the subject's pose.
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
      cos_(std::cos(Radians(view_angle_deg))),
      frame_x_px_(0.5 * (config.width_px - 1)),
      frame_y_px_(0.5 * (config.height_px - 1)),
      half_diagonal_px_(0.5 * std::hypot(config.width_px, config.height_px)),
      distortion_k1_(config.distortion_k1) {}

Point2 PinholeView::PixelFromBench(Point2 p) const noexcept {
  const double depth_mm = distance_mm_ + p.y * sin_;
  const Point2 ideal{center_x_px_ + focal_px_ * p.x / depth_mm,
                     center_y_px_ + focal_px_ * p.y * cos_ / depth_mm};
  const double x = (ideal.x - frame_x_px_) / half_diagonal_px_,
               y = (ideal.y - frame_y_px_) / half_diagonal_px_;
  const double bend = distortion_k1_ * (x * x + y * y);
  return {ideal.x + bend * (ideal.x - frame_x_px_), ideal.y + bend * (ideal.y - frame_y_px_)};
}

Point2 PinholeView::BenchFromPixel(Point2 pixel) const noexcept {
  if (distortion_k1_ != 0.0) {
    const double x = pixel.x - frame_x_px_, y = pixel.y - frame_y_px_;
    const double r = std::hypot(x, y) / half_diagonal_px_;
    double ideal = r;  // Newton on r = ideal (1 + k1 ideal^2)
    for (int i = 0; i < 5; ++i) {
      ideal -=
          (ideal * (1.0 + distortion_k1_ * ideal * ideal) - r) / (1.0 + 3.0 * distortion_k1_ * ideal * ideal);
    }
    const double shrink = r > 0.0 ? ideal / r : 1.0;
    pixel = {frame_x_px_ + shrink * x, frame_y_px_ + shrink * y};
  }
  const double a = (pixel.x - center_x_px_) / focal_px_;
  const double b = (pixel.y - center_y_px_) / focal_px_;
  const double y = b * distance_mm_ / (cos_ - b * sin_);
  return {a * (distance_mm_ + y * sin_), y};
}

// Without the bulge, which leaves the window's border alone.
Point2 BenchFromPatch(const Pose& pose, double window_mm, Point2 patch_mm) noexcept {
  const double c = std::cos(Radians(pose.rotation_deg)), s = std::sin(Radians(pose.rotation_deg));
  const double x = (patch_mm.x - 0.5 * window_mm) * (1.0 + pose.strain_x),
               y = (patch_mm.y - 0.5 * window_mm) * (1.0 + pose.strain_y);
  return {c * x - s * y + pose.shift_x_mm, s * x + c * y + pose.shift_y_mm};
}

Point2 PatchFromBench(const Pose& pose, double window_mm, Point2 bench_mm) noexcept {
  const double c = std::cos(Radians(pose.rotation_deg)), s = std::sin(Radians(pose.rotation_deg));
  const double x = bench_mm.x - pose.shift_x_mm, y = bench_mm.y - pose.shift_y_mm;
  Point2 p{(c * x + s * y) / (1.0 + pose.strain_x) + 0.5 * window_mm,
           (-s * x + c * y) / (1.0 + pose.strain_y) + 0.5 * window_mm};
  const bool inside = p.x > 0.0 && p.y > 0.0 && p.x < window_mm && p.y < window_mm;
  if (inside && (pose.bulge_x_mm != 0.0 || pose.bulge_y_mm != 0.0)) {
    const double hill =
        std::sin(std::numbers::pi * p.x / window_mm) * std::sin(std::numbers::pi * p.y / window_mm);
    p.x -= hill * pose.bulge_x_mm;
    p.y -= hill * pose.bulge_y_mm;
  }
  return p;
}

std::array<Point2, 4> WindowCorners(const PinholeView& view, const Pose& pose, double window_mm) noexcept {
  const auto corner = [&](double x, double y) {
    return view.PixelFromBench(BenchFromPatch(pose, window_mm, {x, y}));
  };
  return {corner(0.0, 0.0), corner(window_mm, 0.0), corner(window_mm, window_mm), corner(0.0, window_mm)};
}

}  // namespace dermap
