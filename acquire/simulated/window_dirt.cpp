// SPDX-License-Identifier: Apache-2.0
// Fibres, hairs and the shadow, drawn once for a scene.
#include "acquire/simulated/window_dirt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acquire/simulated/random_field.h"

namespace dermap {
namespace {

constexpr double kFibresPerSide = 6;
constexpr double kFibreWidth_mm = 0.12;
constexpr double kHairLight = 0.15;   // share of the light that a hair lets through or sends back
constexpr double kGap_mm = 1;         // between two windows
constexpr double kShadowEdge_mm = 1;  // width of the shadow's soft edge

}  // namespace

WindowDirt::WindowDirt(const BenchConfig& config, double window_mm, std::uint64_t seed)
    : window_mm_(window_mm),
      second_mm_(config.second_window_mm),
      corner_mm_(config.corner_radius_mm),
      half_hair_mm_(0.5 * config.hair_mm),
      shadow_(config.shadow) {
  auto random = RandomStream(seed, "window dirt");
  for (int i = 0; config.fray_mm > 0.0 && i < 4 * kFibresPerSide; ++i) {
    const double at_mm = window_mm * Uniform(random);
    const double half_width_mm = kFibreWidth_mm * (0.3 + Uniform(random));
    fibres_.push_back({i % 4, at_mm, half_width_mm, config.fray_mm * Uniform(random)});
  }
  for (int i = 0; i < config.hairs; ++i) {
    const double angle = std::numbers::pi * Uniform(random);
    const double through = window_mm * Uniform(random), across = window_mm * Uniform(random);
    hairs_.push_back(
        {std::cos(angle), std::sin(angle), std::cos(angle) * through + std::sin(angle) * across});
  }
}

bool WindowDirt::InWindow(Point2 p) const noexcept {
  const double beyond = p.x - window_mm_ - kGap_mm;
  if (beyond > 0.0 && beyond < second_mm_ && p.y > 0.0 && p.y < second_mm_) return true;
  if (!(p.x >= 0.0 && p.x < window_mm_ && p.y >= 0.0 && p.y < window_mm_)) return false;
  if (corner_mm_ > 0.0) {
    const double dx = std::max({corner_mm_ - p.x, p.x - (window_mm_ - corner_mm_), 0.0});
    const double dy = std::max({corner_mm_ - p.y, p.y - (window_mm_ - corner_mm_), 0.0});
    if (dx * dx + dy * dy > corner_mm_ * corner_mm_) return false;
  }
  return std::none_of(fibres_.begin(), fibres_.end(), [&](const Fibre& f) {
    const double along = f.side % 2 == 0 ? p.x : p.y;
    const double inwards = f.side == 0   ? p.y
                           : f.side == 1 ? window_mm_ - p.x
                           : f.side == 2 ? window_mm_ - p.y
                                         : p.x;
    return std::abs(along - f.at_mm) < f.half_width_mm * (1.0 - inwards / std::max(1e-9, f.length_mm));
  });
}

double WindowDirt::Clear(Point2 p) const noexcept {
  for (const Hair& h : hairs_) {
    if (std::abs(h.nx * p.x + h.ny * p.y - h.distance_mm) < half_hair_mm_) return kHairLight;
  }
  return 1.0;
}

double WindowDirt::Lit(Point2 p) const noexcept {
  if (shadow_ == 0.0) return 1.0;
  const double beyond = (p.x + p.y - window_mm_) / std::numbers::sqrt2;  // of the diagonal
  return 1.0 - shadow_ * std::clamp(0.5 + beyond / kShadowEdge_mm, 0.0, 1.0);
}

}  // namespace dermap
