// SPDX-License-Identifier: Apache-2.0
// One band of the forward model.
#include "common/transport/band_renderer.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

Border BorderOf(const ImagingConditions& conditions) {
  return conditions.illumination == Illumination::kUniform ? Border::kMirror : Border::kZero;
}

Domain DomainOf(int width, int height, const ImagingConditions& conditions, const ForwardOptions& options) {
  return MakeDomain(width, height, options.margin_mm / conditions.pixel_size_mm);
}

}  // namespace

BandRenderer::BandRenderer(int width, int height, const ImagingConditions& conditions,
                           const ForwardOptions& options)
    : width_(width),
      height_(height),
      conditions_(conditions),
      options_(options),
      mu_a_epidermis_(width, height),
      mu_a_dermis_(width, height),
      transmittance_(width, height),
      node_reflectance_(width, height),
      center_reflectance_(width, height) {
  if (options.engine == Engine::kLowRank) {
    path_series_ = std::make_unique<PathSeries>(width, height, conditions, options);
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
  for (std::size_t i = 0; i < transmittance_.size(); ++i) {
    const double p = junction_absorbance ? junction_absorbance->data()[i] : base_absorbance;
    transmittance_.data()[i] = static_cast<float>(std::exp(-p));
  }
}

void BandRenderer::SetAbsorption(const Absorbers& absorbers, const ParameterMaps& maps) {
  ParameterVector p;
  for (std::size_t i = 0; i < mu_a_epidermis_.size(); ++i) {
    for (int k = 0; k < kParameterCount; ++k) p[k] = maps.planes[k].data()[i];
    mu_a_epidermis_.data()[i] = static_cast<float>(absorbers.MuAEpidermis(p));
    mu_a_dermis_.data()[i] = static_cast<float>(absorbers.MuADermis(p));
  }
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
  if (path_series_) {
    path_series_->Render(input, out);
  } else {
    gaussian_series_->Render(input, out);
  }
}

// Multiplies the render at the band's centre by the whole band's local reflectance over the centre's, pixel
// by pixel: over a filter's width lateral transport hardly changes, absorption may.
void BandRenderer::CorrectForWidth(const BandOptics& band, const std::vector<LocalTotals>& totals,
                                   const ParameterMaps& maps, PlaneF& out) {
  PlaneF& mean = node_reflectance_;
  std::fill(mean.values().begin(), mean.values().end(), 0.0f);
  for (int node = 0; node < static_cast<int>(band.nodes.size()); ++node) {
    SetAbsorption(band.nodes[node].absorbers, maps);
    const float weight = static_cast<float>(band.nodes[node].weight);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const float local =
          totals[node].Reflectance(PositionInTable(mu_a_epidermis_.data()[i]),
                                   PositionInTable(mu_a_dermis_.data()[i]), transmittance_.data()[i]);
      mean.data()[i] += weight * local;
      if (node == band.center) center_reflectance_.data()[i] = local;
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float center = center_reflectance_.data()[i];
    if (center > 0.0f) out.data()[i] *= mean.data()[i] / center;
  }
}

PlaneF BandRenderer::Render(const BandOptics& band, const std::vector<LocalTotals>& totals,
                            const ParameterMaps& maps, const PlaneF* junction_absorbance,
                            double base_absorbance, const PlaneF* light) {
  SetLight(light);
  SetTransmittance(junction_absorbance, base_absorbance);
  PlaneF out(width_, height_);
  if (!options_.full_band_integration) {
    RenderNode(band, band.center, totals[band.center], maps, out);
    if (band.nodes.size() > 1) CorrectForWidth(band, totals, maps, out);
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
