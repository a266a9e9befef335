// SPDX-License-Identifier: Apache-2.0
// Derivatives of a band's render by the maps.
#include <cmath>
#include <utility>

#include "common/transport/band_renderer.h"
#include "common/transport/plane_math.h"

namespace dermap {
namespace {

// change of mu_a += d mu_a / d p * change of p, for the parameters that change.
void AddAbsorptionChange(const Absorbers& a, const ParameterMaps& maps, const ParameterMaps& change,
                         SeriesChanges& mu_a) {
  const std::size_t n = mu_a[0].size();
  const auto plane = [&](Parameter p) { return change[p].empty() ? nullptr : change[p].data(); };
  const float *C_m = plane(Parameter::kC_m), *beta = plane(Parameter::kBeta_m),
              *C_he = plane(Parameter::kC_he);
  const float *C_bc = plane(Parameter::kC_bc), *C_hd = plane(Parameter::kC_hd);
  const auto base = static_cast<float>(a.baseline), type = static_cast<float>(a.eumelanin - a.pheomelanin);
  const auto pheomelanin = static_cast<float>(a.pheomelanin) - base;
  const auto blood = static_cast<float>(a.blood_epidermis) - base,
             carotene = static_cast<float>(a.carotene) - base;
  const auto below = static_cast<float>(a.blood_dermis) - base;
  for (std::size_t i = 0; i < n; ++i) {
    float above = 0.0f;
    if (C_m) above += C_m[i] * (pheomelanin + maps[Parameter::kBeta_m].data()[i] * type);
    if (beta) above += beta[i] * maps[Parameter::kC_m].data()[i] * type;
    if (C_he) above += C_he[i] * blood;
    if (C_bc) above += C_bc[i] * carotene;
    mu_a[0].data()[i] = above;
    mu_a[1].data()[i] = C_hd ? C_hd[i] * below : 0.0f;
  }
}

// derivatives += d mu_a / d p * derivatives by mu_a
void AddAbsorptionDerivatives(const Absorbers& a, const ParameterMaps& maps, const SeriesChanges& by,
                              ParameterMaps& derivatives) {
  const auto base = static_cast<float>(a.baseline), type = static_cast<float>(a.eumelanin - a.pheomelanin);
  const auto pheomelanin = static_cast<float>(a.pheomelanin) - base;
  const auto blood = static_cast<float>(a.blood_epidermis) - base,
             carotene = static_cast<float>(a.carotene) - base;
  const auto below = static_cast<float>(a.blood_dermis) - base;
  for (std::size_t i = 0; i < by[0].size(); ++i) {
    const float above = by[0].data()[i];
    derivatives[Parameter::kC_m].data()[i] +=
        above * (pheomelanin + maps[Parameter::kBeta_m].data()[i] * type);
    derivatives[Parameter::kBeta_m].data()[i] += above * maps[Parameter::kC_m].data()[i] * type;
    derivatives[Parameter::kC_he].data()[i] += above * blood;
    derivatives[Parameter::kC_bc].data()[i] += above * carotene;
    derivatives[Parameter::kC_hd].data()[i] += by[1].data()[i] * below;
  }
}

}  // namespace

// Of a pixel of uniform skin: by mu_a of both layers and by the junction's transmittance.
std::array<double, 3> BandRenderer::LocalDerivatives(const BandOptics& band, std::size_t pixel) const {
  const double A = transmittance_.data()[pixel];
  const auto total = band.nodes[band.center].tables.TotalReflectanceDerivatives(
      mu_a_epidermis_.data()[pixel], mu_a_dermis_.data()[pixel], -std::log(A));
  const double light = local_light_;
  return {light * total.d_mu_a_epidermis, light * total.d_mu_a_dermis,
          -light * total.d_junction_absorbance / A};
}

void BandRenderer::LocalTangent(const BandOptics& band, const SeriesChanges& changes, PlaneF& out) const {
  out = PlaneF(width_, height_);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::array<double, 3> by = LocalDerivatives(band, i);
    for (int k = 0; k < 3; ++k)
      if (!changes[k].empty()) out.data()[i] += static_cast<float>(by[k] * changes[k].data()[i]);
  }
}

void BandRenderer::LocalTranspose(const BandOptics& band, const PlaneF& weights,
                                  SeriesChanges& derivatives) const {
  for (PlaneF& plane : derivatives) plane = PlaneF(width_, height_);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const std::array<double, 3> by = LocalDerivatives(band, i);
    for (int k = 0; k < 3; ++k) derivatives[k].data()[i] = static_cast<float>(by[k] * weights.data()[i]);
  }
}

PlaneF BandRenderer::Tangent(const BandOptics& band, const FilterWidth& width, const ParameterMaps& maps,
                             const ParameterMaps& change, const PlaneF* junction_change) {
  const Absorbers& absorbers = band.nodes[band.center].absorbers;
  SeriesChanges mu_a;
  mu_a[0] = mu_a[1] = PlaneF(width_, height_);
  AddAbsorptionChange(absorbers, maps, change, mu_a);
  if (junction_change) {
    mu_a[2] = *junction_change;  // A = exp(-P)
    for (std::size_t i = 0; i < mu_a[2].size(); ++i) mu_a[2].data()[i] *= -transmittance_.data()[i];
  }
  PlaneF out, ratio;
  if (kept_) {
    kept_->Tangent(mu_a, out);
  } else {
    LocalTangent(band, mu_a, out);
  }
  if (width.empty()) return out;
  std::array<PlaneF, kParameterCount + 1> gradient;
  width.Derivatives({maps, mu_a_epidermis_, mu_a_dermis_, transmittance_}, ratio, gradient);
  MultiplyBy(ratio, out);
  for (int k = 0; k <= kParameterCount; ++k) {
    const PlaneF* step = k < kParameterCount ? &change.planes[k] : &mu_a[2];
    if (step->empty()) continue;
    MultiplyBy(center_reflectance_, gradient[k]);
    AddProduct(gradient[k], *step, out);
  }
  return out;
}

void BandRenderer::Transpose(const BandOptics& band, const FilterWidth& width, const ParameterMaps& maps,
                             PlaneF weights, ParameterMaps& derivatives, PlaneF& junction_derivative) {
  PlaneF ratio;
  std::array<PlaneF, kParameterCount + 1> gradient;
  if (!width.empty()) {
    width.Derivatives({maps, mu_a_epidermis_, mu_a_dermis_, transmittance_}, ratio, gradient);
    for (PlaneF& plane : gradient) {
      MultiplyBy(weights, plane);
      MultiplyBy(center_reflectance_, plane);
    }
    MultiplyBy(ratio, weights);
  }
  SeriesChanges by;
  if (kept_) {
    kept_->Transpose(weights, by);
  } else {
    LocalTranspose(band, weights, by);
  }
  derivatives = ParameterMaps(width_, height_, ParameterVector{});
  AddAbsorptionDerivatives(band.nodes[band.center].absorbers, maps, by, derivatives);
  junction_derivative = std::move(by[2]);
  if (!width.empty()) {
    for (int k = 0; k < kParameterCount; ++k) AddTo(gradient[k], derivatives.planes[k]);
    AddTo(gradient[kParameterCount], junction_derivative);
  }
  for (std::size_t i = 0; i < junction_derivative.size(); ++i)
    junction_derivative.data()[i] *= -transmittance_.data()[i];
}

}  // namespace dermap
