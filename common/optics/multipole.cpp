// SPDX-License-Identifier: Apache-2.0
// Closed forms of the multipole: the images of a source between two faces sum to a geometric series.
//
// A pole at depth z contributes z (1 + sigma_tr rho) exp(-sigma_tr rho) / (4 pi rho^3) to the profile, rho^2
// = r^2 + z^2. Its 2-D Fourier transform is sign(z) exp(-|z| s)/2 with s = sqrt(sigma_tr^2 + k^2). Summed
// over the images at z_r = 2 i L + l and z_v = 2 i L - l - 2 z_b(near), L = d + z_b(near) + z_b(far), for all
// integers i,
//   R = alpha' sinh((d + z_b(far) - l) s) cosh(z_b(near) s) / sinh(L s)
//   T = alpha' sinh((l + z_b(near)) s) cosh(z_b(far) s) / sinh(L s)                 for l <= d
//   T = -alpha' sinh((d + z_b(far) - l) s) cosh((d + z_b(near)) s) / sinh(L s)      for l > d: the sign of
//   one pole turns
#include "common/optics/multipole.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

#include "common/optics/fresnel.h"

namespace dermap {
namespace {

struct Diffusion {
  double albedo, sigma_tr2, mean_free_path_mm, coefficient_mm;
};

Diffusion DiffusionOf(const LayerOptics& layer) {
  assert(layer.mu_a >= 0.0 && layer.mu_s_reduced > 0.0);
  const double sigma_t = layer.mu_a + layer.mu_s_reduced;  // sigma_t', 1/mm
  return {.albedo = layer.mu_s_reduced / sigma_t,
          .sigma_tr2 = 3.0 * layer.mu_a * sigma_t,
          .mean_free_path_mm = 1.0 / sigma_t,
          .coefficient_mm = 1.0 / (3.0 * sigma_t)};
}

double ExtrapolationLength_mm(double a, const Diffusion& diffusion) {
  return 2.0 * a * diffusion.coefficient_mm;
}

// sinh(a s) cosh(b s) / sinh(c s) for b >= 0, c > 0, |a| + b <= c up to rounding; neither overflows for large
// s c nor loses digits for small.
double SinhCoshOverSinh(double a, double b, double c, double s) {
  if (s * c < 1e-150) return a / c;
  const double x = std::abs(a);
  const double sign = a < 0.0 ? -1.0 : 1.0;
  const double ratio = std::expm1(-2.0 * x * s) / std::expm1(-2.0 * c * s);
  return sign * 0.5 * std::exp((x + b - c) * s) * ratio * (1.0 + std::exp(-2.0 * b * s));
}

}  // namespace

double BoundaryMismatch(double n_inside, double n_outside) {
  const double f_dr = DiffuseFresnelReflectance(n_inside, n_outside);
  return (1.0 + f_dr) / (1.0 - f_dr);
}

MultipoleSlab::MultipoleSlab(const LayerOptics& layer, double thickness_mm, double a_near, double a_far)
    : thickness_mm_(thickness_mm) {
  assert(thickness_mm > 0.0 && a_near >= 1.0 && a_far >= 1.0);
  const auto diffusion = DiffusionOf(layer);
  albedo_ = diffusion.albedo;
  sigma_tr2_ = diffusion.sigma_tr2;
  source_mm_ = diffusion.mean_free_path_mm;
  near_mm_ = ExtrapolationLength_mm(a_near, diffusion);
  far_mm_ = ExtrapolationLength_mm(a_far, diffusion);
}

double MultipoleSlab::Decay(double k_per_mm) const {
  return std::sqrt(sigma_tr2_ + k_per_mm * k_per_mm);
}

double MultipoleSlab::Reflectance(double k_per_mm) const {
  const double period = thickness_mm_ + near_mm_ + far_mm_;
  return albedo_ * SinhCoshOverSinh(thickness_mm_ + far_mm_ - source_mm_, near_mm_, period, Decay(k_per_mm));
}

double MultipoleSlab::Transmittance(double k_per_mm) const {
  const double period = thickness_mm_ + near_mm_ + far_mm_;
  const double s = Decay(k_per_mm);
  if (source_mm_ <= thickness_mm_)
    return albedo_ * SinhCoshOverSinh(source_mm_ + near_mm_, far_mm_, period, s);
  return -albedo_ *
         SinhCoshOverSinh(thickness_mm_ + far_mm_ - source_mm_, thickness_mm_ + near_mm_, period, s);
}

DipoleHalfSpace::DipoleHalfSpace(const LayerOptics& layer, double a_near) {
  const auto diffusion = DiffusionOf(layer);
  albedo_ = diffusion.albedo;
  sigma_tr2_ = diffusion.sigma_tr2;
  source_mm_ = diffusion.mean_free_path_mm;
  near_mm_ = ExtrapolationLength_mm(a_near, diffusion);
}

double DipoleHalfSpace::Reflectance(double k_per_mm) const {
  const double s = std::sqrt(sigma_tr2_ + k_per_mm * k_per_mm);
  return 0.5 * albedo_ * (std::exp(-source_mm_ * s) + std::exp(-(source_mm_ + 2.0 * near_mm_) * s));
}

namespace {

class MultipoleSource : public ProfileSource {
 public:
  explicit MultipoleSource(MultipoleDirections directions) : directions_(directions) {}

  std::string_view Name() const override {
    return directions_ == MultipoleDirections::kOwn ? "multipole" : "multipole-symmetric";
  }

  EpidermisTransforms Epidermis(const EpidermisOptics& optics,
                                std::span<const double> k_per_mm) const override {
    const double a_above = optics.black_above ? 1.0 : BoundaryMismatch(optics.layer.n, optics.n_above);
    const double a_below = BoundaryMismatch(optics.layer.n, optics.n_below);
    const double enters = 1.0 - FresnelReflectance(1.0, optics.n_above, optics.layer.n);
    const MultipoleSlab from_above(optics.layer, optics.thickness_mm, a_above, a_below);
    const MultipoleSlab from_below(optics.layer, optics.thickness_mm, a_below, a_above);
    const auto& backward = directions_ == MultipoleDirections::kOwn ? from_below : from_above;
    EpidermisTransforms result;
    for (const double k : k_per_mm) {
      result.r_forward.push_back(enters * from_above.Reflectance(k));
      result.t_forward.push_back(enters * from_above.Transmittance(k));
      result.r_backward.push_back(backward.Reflectance(k));
      result.t_backward.push_back(backward.Transmittance(k));
    }
    return result;
  }

  DermisTransforms Dermis(const DermisOptics& optics, std::span<const double> k_per_mm) const override {
    const DipoleHalfSpace dermis(optics.layer, BoundaryMismatch(optics.layer.n, optics.n_above));
    DermisTransforms result;
    for (const double k : k_per_mm) result.r_diffuse.push_back(dermis.Reflectance(k));
    result.r_normal = result.r_diffuse;
    return result;
  }

 private:
  MultipoleDirections directions_;
};

}  // namespace

std::unique_ptr<ProfileSource> MakeMultipoleSource(MultipoleDirections directions) {
  return std::make_unique<MultipoleSource>(directions);
}

}  // namespace dermap
