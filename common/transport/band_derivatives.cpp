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
  const PlaneF &above = by[0], &C_m = maps[Parameter::kC_m], &beta = maps[Parameter::kBeta_m];
  AddScaled(above, pheomelanin, derivatives[Parameter::kC_m]);
  AddProductScaled(above, beta, type, derivatives[Parameter::kC_m]);
  AddProductScaled(above, C_m, type, derivatives[Parameter::kBeta_m]);
  AddScaled(above, blood, derivatives[Parameter::kC_he]);
  AddScaled(above, carotene, derivatives[Parameter::kC_bc]);
  AddScaled(by[1], below, derivatives[Parameter::kC_hd]);
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
  Fill(out, width_, height_, 0.0f);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::array<double, 3> by = LocalDerivatives(band, i);
    for (int k = 0; k < 3; ++k)
      if (!changes[k].empty()) out.data()[i] += static_cast<float>(by[k] * changes[k].data()[i]);
  }
}

void BandRenderer::LocalTranspose(const BandOptics& band, const PlaneF& weights,
                                  SeriesChanges& derivatives) const {
  for (PlaneF& plane : derivatives) EnsureShape(plane, width_, height_);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const std::array<double, 3> by = LocalDerivatives(band, i);
    for (int k = 0; k < 3; ++k) derivatives[k].data()[i] = static_cast<float>(by[k] * weights.data()[i]);
  }
}

void BandRenderer::Tangent(const BandOptics& band, const FilterWidth& width, const ParameterMaps& maps,
                           const ParameterMaps& change, const PlaneF* junction_change, PlaneF& out) {
  const Absorbers& absorbers = band.nodes[band.center].absorbers;
  EnsureShape(by_[0], width_, height_);
  EnsureShape(by_[1], width_, height_);
  AddAbsorptionChange(absorbers, maps, change, by_);
  if (junction_change) {  // A = exp(-P)
    Product(*junction_change, transmittance_, by_[2]);
    Scaled(by_[2], -1.0f, by_[2]);
  } else {
    by_[2] = PlaneF();
  }
  if (kept_) {
    kept_->Tangent(by_, out);
  } else {
    LocalTangent(band, by_, out);
  }
  if (width.empty()) return;
  width.Derivatives({maps, mu_a_epidermis_, mu_a_dermis_, transmittance_}, ratio_, gradient_);
  MultiplyBy(ratio_, out);
  for (int k = 0; k <= kParameterCount; ++k) {
    const PlaneF* step = k < kParameterCount ? &change.planes[k] : &by_[2];
    if (step->empty()) continue;
    MultiplyBy(center_reflectance_, gradient_[k]);
    AddProduct(gradient_[k], *step, out);
  }
}

void BandRenderer::Transpose(const BandOptics& band, const FilterWidth& width, const ParameterMaps& maps,
                             PlaneF& weights, ParameterMaps& derivatives, PlaneF& junction_derivative) {
  if (!width.empty()) {
    width.Derivatives({maps, mu_a_epidermis_, mu_a_dermis_, transmittance_}, ratio_, gradient_);
    Product(weights, center_reflectance_, by_[0]);
    for (PlaneF& plane : gradient_) MultiplyBy(by_[0], plane);
    MultiplyBy(ratio_, weights);
  }
  if (kept_) {
    kept_->Transpose(weights, by_);
  } else {
    LocalTranspose(band, weights, by_);
  }
  EnsureShape(junction_derivative, width_, height_);
  for (int k = 0; k < kParameterCount; ++k) {
    if (width.empty()) {
      Fill(derivatives.planes[k], width_, height_, 0.0f);
    } else {
      std::swap(derivatives.planes[k], gradient_[k]);
    }
  }
  AddAbsorptionDerivatives(band.nodes[band.center].absorbers, maps, by_, derivatives);
  if (!width.empty()) AddTo(gradient_[kParameterCount], by_[2]);
  Product(by_[2], transmittance_, junction_derivative);
  Scaled(junction_derivative, -1.0f, junction_derivative);
}

}  // namespace dermap
