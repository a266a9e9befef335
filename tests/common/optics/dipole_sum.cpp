// SPDX-License-Identifier: Apache-2.0
// Dipoles, one by one [Donner and Jensen 2005].
#include "tests/common/optics/dipole_sum.h"

#include <cmath>
#include <numbers>

namespace dermap {
namespace {

// What a pole at height z over the point of exit sends through the face there, 1/mm^2.
double Pole(double z, double r, double sigma_tr) {
  const double rho = std::sqrt(r * r + z * z);
  return z * (1.0 + sigma_tr * rho) * std::exp(-sigma_tr * rho) / (4.0 * std::numbers::pi * rho * rho * rho);
}

struct Image {
  double real_mm, virtual_mm;  // depths of the two poles
};

Image ImageOf(const DipoleSlab& slab, int i) {
  const double sigma_t = slab.mu_a + slab.mu_s_reduced;
  const double l = 1.0 / sigma_t;
  const double diffusion = l / 3.0;
  const double z_near = 2.0 * slab.a_near * diffusion;
  const double z_far = 2.0 * slab.a_far * diffusion;
  const double shift = 2.0 * i * (slab.thickness_mm + z_near + z_far);
  return {shift + l, shift - l - 2.0 * z_near};
}

double Sum(const DipoleSlab& slab, int images, double r_mm, bool transmitted) {
  const double sigma_t = slab.mu_a + slab.mu_s_reduced;
  const double sigma_tr = std::sqrt(3.0 * slab.mu_a * sigma_t);
  double sum = 0.0;
  for (int i = -images; i <= images; ++i) {
    const auto [real, mirrored] = ImageOf(slab, i);
    if (transmitted) {
      sum +=
          Pole(slab.thickness_mm - real, r_mm, sigma_tr) - Pole(slab.thickness_mm - mirrored, r_mm, sigma_tr);
    } else {
      sum += Pole(real, r_mm, sigma_tr) - Pole(mirrored, r_mm, sigma_tr);
    }
  }
  return slab.mu_s_reduced / sigma_t * sum;
}

}  // namespace

double DipoleSumReflectance(const DipoleSlab& slab, double r_mm, int images) {
  return Sum(slab, images, r_mm, false);
}

double DipoleSumTransmittance(const DipoleSlab& slab, double r_mm, int images) {
  return Sum(slab, images, r_mm, true);
}

}  // namespace dermap
