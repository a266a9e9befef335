// SPDX-License-Identifier: Apache-2.0
// Skins put together from flux matrices.
#include "common/optics/plane_skin.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/optics/fresnel.h"

namespace dermap {
namespace {

enum Medium { kOutside, kEpidermis, kDermis };
constexpr int kNormal = 0;  // node of light along the normal

LightOperators TurnedOver(const LightOperators& part) {
  return {part.r_up, part.t_up, part.r_down, part.t_down};
}

// Henyey-Greenstein, mean over the sphere 1, of light along the normal that turns back at cosine mu.
double BackwardPhase(double g, double mu) {
  return (1.0 - g * g) / std::pow(1.0 + g * g + 2.0 * g * mu, 1.5);
}

}  // namespace

PlaneSkin::PlaneSkin(const TissueConfig& config)
    : anisotropy_(config.anisotropy),
      grid_(MakeAngularGrid(std::array{config.n_outside, config.n_epidermis, config.n_dermis})),
      surface_(SolveFace(grid_, kOutside, kEpidermis)),
      junction_(SolveFace(grid_, kEpidermis, kDermis)),
      specular_(FresnelReflectance(1.0, config.n_outside, config.n_epidermis)) {}

LightOperators PlaneSkin::Epidermis(double mu_a, double mu_s_reduced, double thickness_mm) const {
  return Add(surface_, SolvePlaneLayer(grid_, kEpidermis,
                                       {.mu_a = mu_a,
                                        .mu_s = RealScattering(mu_s_reduced),
                                        .anisotropy = anisotropy_,
                                        .thickness_mm = thickness_mm}));
}

LightOperators PlaneSkin::Dermis(double mu_a, double mu_s_reduced, double thickness_mm) const {
  return SolvePlaneLayer(grid_, kDermis,
                         {.mu_a = mu_a,
                          .mu_s = RealScattering(mu_s_reduced),
                          .anisotropy = anisotropy_,
                          .thickness_mm = thickness_mm});
}

PlaneSkin::Light PlaneSkin::EpidermisAlone(const LightOperators& epidermis) const {
  const LightOperators whole = Add(epidermis, junction_);
  return {whole.r_down.col(kNormal).sum() - specular_, whole.t_down.col(kNormal).sum()};
}

PlaneSkin::Light PlaneSkin::TwoLayers(const LightOperators& epidermis, const LightOperators& dermis,
                                      double junction_absorbance) const {
  const LightOperators face = SolveFace(grid_, kEpidermis, kDermis, junction_absorbance);
  const LightOperators whole = Add(epidermis, Add(face, dermis));
  return {whole.r_down.col(kNormal).sum() - specular_, whole.t_down.col(kNormal).sum()};
}

PlaneSkin::Light PlaneSkin::ThinPart(const LightOperators& epidermis, const LightOperators& dermis,
                                     double junction_absorbance) const {
  const LightOperators upper = Add(epidermis, SolveFace(grid_, kEpidermis, kDermis, junction_absorbance));
  const LightOperators whole = Add(Add(upper, dermis), TurnedOver(upper));
  return {whole.r_down.col(kNormal).sum() - specular_, whole.t_down.col(kNormal).sum()};
}

double PlaneSkin::DermisAlone(const LightOperators& dermis) const {
  const LightOperators whole = Add(junction_, dermis);
  Eigen::VectorXd light = grid_.mu[kEpidermis].cwiseProduct(grid_.weight[kEpidermis]);
  light /= light.sum();
  const double mirrored = (junction_.r_down * light).sum(), crosses = (junction_.t_down * light).sum();
  return ((whole.r_down * light).sum() - mirrored) / crosses;
}

double PlaneSkin::SingleScattering(double mu_a_epidermis, double mu_s_reduced_epidermis, double thickness_mm,
                                   double mu_a_dermis, double mu_s_reduced_dermis,
                                   double junction_absorbance) const {
  const double mu_s_upper = RealScattering(mu_s_reduced_epidermis),
               mu_s_lower = RealScattering(mu_s_reduced_dermis);
  const double mu_t_upper = mu_a_epidermis + mu_s_upper, mu_t_lower = mu_a_dermis + mu_s_lower;
  const auto turned = [&](int medium,
                          int node) {  // share of a scattering, over mu, that turns into this node
    const double mu = grid_.mu[medium](node);
    return 0.5 * BackwardPhase(anisotropy_, mu) * grid_.weight[medium](node) / (1.0 + 1.0 / mu);
  };
  const double to_junction =
      std::exp(-mu_t_upper * thickness_mm - junction_absorbance) * junction_.t_down.coeff(kNormal, kNormal);
  double single = 0.0;
  for (int i = 0; i < grid_.Size(kOutside) && i < grid_.Size(kEpidermis); ++i) {
    const double slant = 1.0 / grid_.mu[kEpidermis](i), leaves = surface_.t_up(i, i);
    single += leaves * turned(kEpidermis, i) * mu_s_upper / mu_t_upper *
              -std::expm1(-mu_t_upper * thickness_mm * (1.0 + slant));
    if (i >= grid_.Size(kDermis)) continue;
    const double back =
        std::exp(-mu_t_upper * thickness_mm * slant - junction_absorbance) * junction_.t_up(i, i);
    single += leaves * to_junction * back * turned(kDermis, i) * mu_s_lower / mu_t_lower;
  }
  return (1.0 - specular_) * single;
}

}  // namespace dermap
