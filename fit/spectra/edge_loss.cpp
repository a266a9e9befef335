// SPDX-License-Identifier: Apache-2.0
// R(r) of some 200 skins, integrated over what the aperture misses.
#include "fit/spectra/edge_loss.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/core/error.h"
#include "common/optics/gauss_legendre.h"
#include "common/optics/homogeneous_skin.h"

namespace dermap {
namespace {

constexpr double kLeastLoss = 1e-7;
constexpr double kReach_mm = 20.0;  // beyond both radii; farther away there is no light left

void Check(double radius_mm) {
  if (radius_mm >= 0.5 && radius_mm <= 50.0) return;
  throw InputError(
      fmt::format("The aperture has a radius of {} mm; expected 0.5 to 50 mm (half of the diameter that the "
                  "instrument's data sheet names).",
                  radius_mm));
}

// Weights on R(r) at some radii that sum up to what is lost.
struct MissedLight {
  std::vector<double> radii_mm, weights;

  explicit MissedLight(const Aperture& aperture) {
    const double near = std::abs(aperture.illuminated_radius_mm - aperture.measured_radius_mm);
    const double far = aperture.illuminated_radius_mm + aperture.measured_radius_mm;
    // Light that is lost falls off like exp(-r / mm), the kink at `near` apart: short panels come first.
    const double end = far + kReach_mm;
    for (double from = std::max(near, 0.02), width = 1.0; from < end; width *= 2.0) {
      double to = std::min(from + width, end);
      if (from < far && to > far) to = far;
      const QuadratureRule rule = GaussLegendreRule(5, from, to);
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double r = rule.nodes[i];
        radii_mm.push_back(r);
        weights.push_back(rule.weights[i] * 2.0 * std::numbers::pi * r * (1.0 - DiscOverlap(aperture, r)));
      }
      from = to;
    }
  }
};

}  // namespace

double DiscOverlap(const Aperture& aperture, double distance_mm) {
  const double a = std::min(aperture.measured_radius_mm, aperture.illuminated_radius_mm);
  const double b = std::max(aperture.measured_radius_mm, aperture.illuminated_radius_mm);
  const double r = distance_mm;
  if (r <= b - a) return 1.0;
  if (r >= a + b) return 0.0;
  const double angle_a = std::acos(std::clamp((r * r + a * a - b * b) / (2.0 * r * a), -1.0, 1.0));
  const double angle_b = std::acos(std::clamp((r * r + b * b - a * a) / (2.0 * r * b), -1.0, 1.0));
  const double lens = a * a * (angle_a - std::sin(angle_a) * std::cos(angle_a)) +
                      b * b * (angle_b - std::sin(angle_b) * std::cos(angle_b));
  return lens / (std::numbers::pi * a * a);
}

const std::array<GridAxis, 3>& EdgeLoss::Axes() {
  static const std::array<GridAxis, 3> axes{GridAxis{std::log(1.0), std::log(40.0), 6},
                                            GridAxis{std::log(1e-3), std::log(1.0), 4},
                                            GridAxis{std::log(0.008), std::log(1.0), 8}};
  return axes;
}

EdgeLoss::EdgeLoss(const Aperture& aperture, const TissueConfig& config, const ProgressFunction& progress) {
  Check(aperture.measured_radius_mm);
  Check(aperture.illuminated_radius_mm);
  const MissedLight missed(aperture);
  TissueConfig isotropic = config;
  isotropic.anisotropy = 0.0;
  SkinRequest request;
  request.radii_mm = missed.radii_mm;
  const auto& [scattering, upper, lower] = Axes();
  std::vector<SkinRow> rows;
  for (int i = 0; i < scattering.count; ++i) {
    for (int j = 0; j < upper.count; ++j) {
      for (int k = 0; k < lower.count; ++k) {
        const double mu_s = std::exp(scattering.At(i));
        rows.push_back({.mu_a_epidermis = std::exp(upper.At(j)) / kThickness_mm,
                        .mu_a_dermis = std::exp(lower.At(k)),
                        .junction_absorbance = config.junction_absorbance,
                        .mu_s_reduced_epidermis = mu_s,
                        .mu_s_reduced_dermis = 0.5 * mu_s,
                        .epidermis_thickness_mm = kThickness_mm});
      }
    }
  }
  std::vector<double> log_loss;
  for (const SkinResponses& skin : HomogeneousSkin(request, isotropic).Evaluate(rows, progress)) {
    double lost = 0.0;
    for (std::size_t i = 0; i < missed.weights.size(); ++i)
      lost += missed.weights[i] * skin.radial_per_mm2[i];
    log_loss.push_back(std::log(std::max(lost / skin.reflectance, kLeastLoss)));
  }
  grid_ = Grid3(Axes(), std::move(log_loss), 4);
}

}  // namespace dermap
