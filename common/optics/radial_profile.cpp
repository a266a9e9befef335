// SPDX-License-Identifier: Apache-2.0
// Hankel's transform by quadrature on interpolated samples, and single scattering by quadrature over depth.
#include "common/optics/radial_profile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "common/optics/fresnel.h"
#include "common/optics/gauss_legendre.h"
#include "common/optics/layers.h"

namespace dermap {
namespace {

constexpr int kStencil = 6;
constexpr double kTurn_per_mm = 0.1;  // interpolation is in asinh(k / this): like log k above, like k below
// What is left after single scattering is smoothed by a Gaussian of this width, too narrow to be seen at the
// radii of interest, so that the integral over k ends.
constexpr double kSmoothing_mm = 0.0015;

constexpr int kFrequencyCount = 77;
constexpr double kFirst_per_mm = 0.02;
constexpr double kLast_per_mm = 1600.0;
constexpr double kLargestKappa =
    15.0;  // asked for; beyond it what is left after single scattering falls as 1 / k^2

const std::vector<double>& AllFrequencies() {
  static const std::vector<double> frequencies = [] {
    std::vector<double> k{0.0};
    const double step = std::log(kLast_per_mm / kFirst_per_mm) / (kFrequencyCount - 2);
    for (int i = 0; i < kFrequencyCount - 1; ++i) k.push_back(kFirst_per_mm * std::exp(step * i));
    return k;
  }();
  return frequencies;
}

double Coordinate(double k) {
  return std::asinh(k / kTurn_per_mm);
}

// Adds `amount` times Lagrange's weights at k; beyond the last sample the transform goes on as 1 / k^2.
void Spread(double k, double amount, const std::vector<double>& samples,
            const std::vector<double>& coordinates, std::vector<double>& weights) {
  if (k >= samples.back()) {
    weights.back() += amount * samples.back() * samples.back() / (k * k);
    return;
  }
  const int count = static_cast<int>(samples.size()), stencil = std::min(kStencil, count);
  const int above = static_cast<int>(std::upper_bound(samples.begin(), samples.end(), k) - samples.begin());
  const int first = std::clamp(above - stencil / 2, 0, count - stencil);
  const double x = Coordinate(k);
  for (int i = first; i < first + stencil; ++i) {
    double weight = amount;
    for (int j = first; j < first + stencil; ++j) {
      if (j != i) weight *= (x - coordinates[j]) / (coordinates[i] - coordinates[j]);
    }
    weights[i] += weight;
  }
}

std::vector<double> HankelWeights(const std::vector<double>& samples, double radius_mm) {
  std::vector<double> coordinates, weights(samples.size(), 0.0);
  for (const double k : samples) coordinates.push_back(Coordinate(k));
  const double last = 5.0 / kSmoothing_mm;
  const QuadratureRule rule = GaussLegendreRule(8, 0.0, 1.0);
  double k = 0.0;
  std::size_t next = 1;
  while (k < last) {
    // Panels end at the samples, where the interpolating polynomial changes, and hold less than a wave of
    // J_0.
    const double limit = next < samples.size() ? samples[next] : last;
    const double width = std::min(limit - k, 2.0 / radius_mm);
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const double at = k + width * rule.nodes[i], smooth = at * kSmoothing_mm;
      const double amount = width * rule.weights[i] * at * std::exp(-0.5 * smooth * smooth) *
                            std::cyl_bessel_j(0.0, at * radius_mm) / (2.0 * std::numbers::pi);
      Spread(at, amount, samples, coordinates, weights);
    }
    k += width;
    if (k >= limit * (1.0 - 1e-12)) {
      k = limit;
      ++next;
    }
  }
  return weights;
}

}  // namespace

RadialProfile::RadialProfile(std::span<const double> radii_mm) : radii_mm_(radii_mm.begin(), radii_mm.end()) {
  for (const double radius : radii_mm_) weights_.push_back(HankelWeights(AllFrequencies(), radius));
}

std::span<const double> RadialProfile::Frequencies_per_mm(double mu_t) {
  const std::vector<double>& all = AllFrequencies();
  const auto end = std::upper_bound(all.begin(), all.end(), kLargestKappa * mu_t);
  return {all.begin(), end};
}

std::vector<double> RadialProfile::At(const EpidermisOptics& optics, const EpidermisTransforms& epidermis,
                                      const DermisTransforms& dermis, double junction_absorbance) const {
  std::vector<double> transform = TwoLayerReflectance(epidermis, dermis, junction_absorbance);
  const bool split = !epidermis.r_single.empty();
  if (split) {
    for (std::size_t i = 0; i < transform.size(); ++i) transform[i] -= epidermis.r_single[i];
  }
  const std::vector<double>& k = AllFrequencies();
  assert(!transform.empty() && transform.size() <= k.size());
  const double last = transform.back() * k[transform.size() - 1] * k[transform.size() - 1];
  for (std::size_t i = transform.size(); i < k.size(); ++i) transform.push_back(last / (k[i] * k[i]));
  std::vector<double> values;
  for (std::size_t j = 0; j < radii_mm_.size(); ++j) {
    double value = split ? SingleScatteringProfile(optics, radii_mm_[j]) : 0.0;
    for (std::size_t i = 0; i < transform.size(); ++i) value += weights_[j][i] * transform[i];
    values.push_back(value);
  }
  return values;
}

double SingleScatteringProfile(const EpidermisOptics& optics, double radius_mm) {
  const double mu_t = optics.layer.mu_a + optics.layer.mu_s_reduced, n = optics.layer.n;
  // Over the angle of exit: z = r / tan(theta), within what the surface lets out and the layer holds.
  const double widest = optics.n_above < n ? std::asin(optics.n_above / n) : 0.5 * std::numbers::pi;
  const double narrowest = std::atan(radius_mm / optics.thickness_mm);
  if (narrowest >= widest) return 0.0;
  // Fresnel's transmittance rises like a root at the critical angle: theta = widest - u^2.
  const QuadratureRule rule = GaussLegendreRule(24, 0.0, std::sqrt(widest - narrowest));
  double sum = 0.0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double theta = widest - rule.nodes[i] * rule.nodes[i], mu = std::cos(theta), sine = std::sin(theta);
    const double depth = radius_mm * mu / sine, path = radius_mm / sine;
    const double passes = 1.0 - FresnelReflectance(mu, n, optics.n_above);
    // mu_s' exp(-mu_t (z + path)) (1 - F) mu / (4 pi path^2) dz, and dz = r / sin^2(theta) dtheta
    sum += rule.weights[i] * 2.0 * rule.nodes[i] * std::exp(-mu_t * (depth + path)) * passes * mu / radius_mm;
  }
  return (1.0 - FresnelReflectance(1.0, optics.n_above, n)) * optics.layer.mu_s_reduced * sum /
         (4.0 * std::numbers::pi);
}

}  // namespace dermap
