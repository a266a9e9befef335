// SPDX-License-Identifier: Apache-2.0
// Fresnel's equations and their integral over Lambertian light.
#include "common/optics/fresnel.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace dermap {
namespace {

// Lambertian light from the rarer side, where F is smooth in the cosine (from the denser side it has a root
// at the critical angle). Double exponential quadrature (Takahasi and Mori 1974): mu = 1/(1 + exp(-pi sinh
// t)), steps of t. The ends t = -3.5 and 3.5 lie 2e-23 from mu = 0 and 1; halving the step changes nothing
// beyond 1e-14.
double DiffuseReflectanceFromRarerSide(double n_rarer, double n_denser) noexcept {
  constexpr double kStep = 1.0 / 32.0;
  constexpr int kSteps = 112;
  double sum = 0.0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double t = i * kStep;
    const double decay = std::exp(-std::numbers::pi * std::sinh(t));
    const double mu = 1.0 / (1.0 + decay);
    const double d_mu =
        std::numbers::pi * std::cosh(t) * mu * (decay * mu);  // (1 - mu) = decay * mu, without cancellation
    sum += 2.0 * mu * FresnelReflectance(mu, n_rarer, n_denser) * d_mu * kStep;
  }
  return sum;
}

}  // namespace

double FresnelReflectance(double cos_incidence, double n_from, double n_to) noexcept {
  assert(cos_incidence >= 0.0 && cos_incidence <= 1.0 && n_from > 0.0 && n_to > 0.0);
  const double ratio = n_from / n_to;
  const double sin2_refraction = ratio * ratio * (1.0 - cos_incidence * cos_incidence);  // Snell
  if (sin2_refraction >= 1.0) return 1.0;
  const double cos_refraction = std::sqrt(1.0 - sin2_refraction);
  const double s =
      (n_from * cos_incidence - n_to * cos_refraction) / (n_from * cos_incidence + n_to * cos_refraction);
  const double p =
      (n_to * cos_incidence - n_from * cos_refraction) / (n_to * cos_incidence + n_from * cos_refraction);
  return 0.5 * (s * s + p * p);
}

double DiffuseFresnelReflectance(double n_from, double n_to) noexcept {
  if (n_from == n_to) return 0.0;
  if (n_from < n_to) return DiffuseReflectanceFromRarerSide(n_from, n_to);
  // Reversed rays: n_from^2 (1 - F from there) = n_to^2 (1 - F from the other side).
  const double ratio = n_to / n_from;
  return 1.0 - ratio * ratio * (1.0 - DiffuseReflectanceFromRarerSide(n_to, n_from));
}

}  // namespace dermap
