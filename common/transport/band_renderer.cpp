// SPDX-License-Identifier: Apache-2.0
// One band of the forward model.
#include "common/transport/band_renderer.h"

#include <algorithm>
#include <cmath>

#include "common/core/kernel.h"

namespace dermap {
namespace {

// Absorbers::MuAEpidermis of every pixel.
DERMAP_KERNEL
void EpidermisAbsorption(const float* C_m, const float* beta_m, const float* C_he, const float* C_bc,
                         const Absorbers& a, std::size_t n, float* __restrict mu_a) noexcept {
  const auto baseline = static_cast<float>(a.baseline);
  const auto pheomelanin = static_cast<float>(a.pheomelanin - a.baseline);
  const auto eumelanin = static_cast<float>(a.eumelanin - a.pheomelanin);
  const auto blood = static_cast<float>(a.blood_epidermis - a.baseline);
  const auto carotene = static_cast<float>(a.carotene - a.baseline);
  for (std::size_t i = 0; i < n; ++i)
    mu_a[i] =
        baseline + C_m[i] * (pheomelanin + beta_m[i] * eumelanin) + C_he[i] * blood + C_bc[i] * carotene;
}

// Absorbers::MuADermis of every pixel.
DERMAP_KERNEL
void DermisAbsorption(const float* C_hd, const Absorbers& a, std::size_t n, float* __restrict mu_a) noexcept {
  const auto baseline = static_cast<float>(a.baseline),
             blood = static_cast<float>(a.blood_dermis - a.baseline);
  for (std::size_t i = 0; i < n; ++i) mu_a[i] = baseline + C_hd[i] * blood;
}

Border BorderOf(const ImagingConditions& conditions) {
  return conditions.illumination == Illumination::kUniform ? Border::kMirror : Border::kZero;
}

Domain DomainOf(int width, int height, const ImagingConditions& conditions, const ForwardOptions& options) {
  return MakeDomain(width, height, options.margin_mm / conditions.pixel_size_mm);
}

}  // namespace

BandRenderer::BandRenderer(int width, int height, const ImagingConditions& conditions,
                           const ForwardOptions& options, PathPlans& plans)
    : width_(width),
      height_(height),
      conditions_(conditions),
      options_(options),
      plans_(plans),
      mu_a_epidermis_(width, height),
      mu_a_dermis_(width, height),
      transmittance_(width, height),
      node_reflectance_(width, height) {
  if (options.engine == Engine::kLowRank) {
    path_light_ = std::make_unique<PathLight>(width, height, conditions, options);
  } else {
    const Domain domain = DomainOf(width, height, conditions, options);
    gaussian_series_ = std::make_unique<ScatteringSeries>(
        domain, MakeConvolver(options.engine, domain, conditions.pixel_size_mm, BorderOf(conditions)));
  }
}

void BandRenderer::SetLight(const PlaneF* light) {
  const PlaneF ones = light ? PlaneF() : PlaneF(width_, height_, 1.0f);
  const PlaneF& patch = light ? *light : ones;
  if (conditions_.illumination == Illumination::kUniform) {
    ReplicateOutwards(patch, domain(), light_);
  } else {
    SurroundWithZeros(patch, domain(), light_);
  }
}

// A = exp(-P) [D08 eq. 8]
void BandRenderer::SetTransmittance(const PlaneF* junction_absorbance, double base_absorbance) {
  if (!junction_absorbance) {
    std::fill(transmittance_.values().begin(), transmittance_.values().end(),
              static_cast<float>(std::exp(-base_absorbance)));
    return;
  }
  std::transform(junction_absorbance->values().begin(), junction_absorbance->values().end(),
                 transmittance_.values().begin(), [](float p) { return std::exp(-p); });
}

void BandRenderer::SetAbsorption(const Absorbers& absorbers, const ParameterMaps& maps) {
  const std::size_t n = mu_a_epidermis_.size();
  EpidermisAbsorption(maps[Parameter::kC_m].data(), maps[Parameter::kBeta_m].data(),
                      maps[Parameter::kC_he].data(), maps[Parameter::kC_bc].data(), absorbers, n,
                      mu_a_epidermis_.data());
  DermisAbsorption(maps[Parameter::kC_hd].data(), absorbers, n, mu_a_dermis_.data());
}

void BandRenderer::RenderNode(const BandOptics& band, int node, const LocalTotals& totals,
                              const ParameterMaps& maps, PlaneF& out) {
  SetAbsorption(band.nodes[node].absorbers, maps);
  const bool black_tape =
      conditions_.illumination == Illumination::kWindow && conditions_.tape == Tape::kBlack;
  const BandOptics::Node& optics = band.nodes[node];
  const SeriesInput input{optics.tables,   totals,       optics.mu_s_epidermis, optics.mu_s_dermis,
                          mu_a_epidermis_, mu_a_dermis_, transmittance_,        light_,
                          black_tape,      band.terms,   options_.close_series};
  if (path_light_) {
    path_light_->Render(input, plans_, out);
  } else {
    gaussian_series_->Render(input, out);
  }
}

PlaneF BandRenderer::Render(const BandOptics& band, const std::vector<LocalTotals>& totals,
                            const FilterWidth& width, const ParameterMaps& maps,
                            const PlaneF* junction_absorbance, double base_absorbance, const PlaneF* light) {
  SetLight(light);
  SetTransmittance(junction_absorbance, base_absorbance);
  PlaneF out(width_, height_);
  if (!options_.full_band_integration) {
    RenderNode(band, band.center, totals[band.center], maps, out);
    width.Multiply({maps, mu_a_epidermis_, mu_a_dermis_, transmittance_}, out);
    return out;
  }
  for (std::size_t node = 0; node < band.nodes.size(); ++node) {
    RenderNode(band, static_cast<int>(node), totals[node], maps, node_reflectance_);
    const float weight = static_cast<float>(band.nodes[node].weight);
    for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] += weight * node_reflectance_.data()[i];
  }
  return out;
}

}  // namespace dermap
