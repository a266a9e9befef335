// SPDX-License-Identifier: Apache-2.0
// One band of the forward model.
#include "common/transport/band_renderer.h"

#include <algorithm>
#include <cmath>

#include "common/core/kernel.h"
#include "common/transport/paths/path_choice.h"
#include "common/transport/plane_math.h"

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

constexpr double kGaussianMargin_mm = 1.9;

Border BorderOf(const ImagingConditions& conditions) {
  return conditions.illumination == Illumination::kUniform ? Border::kMirror : Border::kZero;
}

Domain DomainOf(int width, int height, const ImagingConditions& conditions, const ForwardOptions& options) {
  return MakeDomain(width, height,
                    (options.margin_mm == kAutomaticMargin ? kGaussianMargin_mm : options.margin_mm) /
                        conditions.pixel_size_mm);
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
  if (options.engine == Engine::kLowRank) return;
  const Domain domain = DomainOf(width, height, conditions, options);
  gaussian_series_ = std::make_unique<ScatteringSeries>(
      domain, MakeConvolver(options.engine, domain, conditions.pixel_size_mm, BorderOf(conditions)),
      conditions.illumination == Illumination::kWindow ? options.beneath_tape : BeneathTape::kEdge);
}

void BandRenderer::SetLight(const PlaneF* light, const Domain& domain) {
  if (!light && unlit_.empty()) unlit_ = PlaneF(width_, height_, 1.0f);
  const PlaneF& patch = light ? *light : unlit_;
  if (conditions_.illumination == Illumination::kUniform) {
    ReplicateOutwards(patch, domain, light_);
  } else {
    SurroundWithZeros(patch, domain, light_);
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

PathLight& BandRenderer::LightWithMargin(double margin_mm) {
  // A few margins serve all bands: rounded up to 0.2 mm.
  const double margin = std::ceil(std::max(margin_mm * 5.0 - 1e-9, 0.0)) / 5.0;
  for (const auto& light : path_lights_)
    if (light->margin_mm() == margin) return *light;
  path_lights_.push_back(std::make_unique<PathLight>(width_, height_, conditions_, margin, options_));
  return *path_lights_.back();
}

// As much of the model as this band of the scene needs.
void BandRenderer::RenderPaths(const BandOptics::Node& optics, const LocalTotals& totals, int most_terms,
                               bool black_tape, const PlaneF* light, PlaneF& out) {
  const auto same = [](const PlaneF& plane) {
    return std::all_of(plane.values().begin(), plane.values().end(),
                       [&](float value) { return value == plane.data()[0]; });
  };
  SceneRange scene;
  scene.epidermis = RangeOf(mu_a_epidermis_, options_.tolerance);
  scene.dermis = RangeOf(mu_a_dermis_, options_.tolerance);
  scene.most_transmittance =
      *std::max_element(transmittance_.values().begin(), transmittance_.values().end());
  scene.uniform_besides =
      conditions_.illumination == Illumination::kUniform && same(transmittance_) && (!light || same(*light));
  choice_ = ChooseModel(optics.tables, totals, optics.mu_s_dermis, scene, black_tape, conditions_, options_,
                        most_terms);
  if (choice_.rung == Rung::kLocal) {
    kept_ = nullptr;
    EnsureShape(out, width_, height_);
    local_light_ = light ? light->data()[0] : 1.0f;
    for (std::size_t i = 0; i < out.size(); ++i)
      out.data()[i] = local_light_ * totals.Reflectance(PositionInTable(mu_a_epidermis_.data()[i]),
                                                        PositionInTable(mu_a_dermis_.data()[i]),
                                                        transmittance_.data()[i]);
    return;
  }
  PathLight& path_light = LightWithMargin(choice_.margin_mm);
  kept_ = &path_light;
  SetLight(light, path_light.domain());
  const SeriesInput input{optics.tables,   totals,        optics.mu_s_epidermis, optics.mu_s_dermis,
                          mu_a_epidermis_, mu_a_dermis_,  transmittance_,        light_,
                          black_tape,      choice_.terms, options_.close_series};
  choice_.margin_mm = path_light.margin_mm();
  path_light.Render(input, plans_, keep_, out);
  AddPaths(path_light.plan(), path_light.frames(), options_.tolerance, choice_);
}

BandChoice BandRenderer::choice() const {
  BandChoice choice = choice_;
  choice.why = Explain(choice_, conditions_.illumination == Illumination::kWindow);
  return choice;
}

void BandRenderer::RenderNode(const BandOptics& band, int node, const LocalTotals& totals,
                              const ParameterMaps& maps, const PlaneF* light, PlaneF& out) {
  SetAbsorption(band.nodes[node].absorbers, maps);
  const bool black_tape =
      conditions_.illumination == Illumination::kWindow && conditions_.tape == Tape::kBlack;
  const BandOptics::Node& optics = band.nodes[node];
  if (!gaussian_series_) return RenderPaths(optics, totals, band.terms, black_tape, light, out);
  SetLight(light, gaussian_series_->domain());
  const SeriesInput input{optics.tables,   totals,       optics.mu_s_epidermis, optics.mu_s_dermis,
                          mu_a_epidermis_, mu_a_dermis_, transmittance_,        light_,
                          black_tape,      band.terms,   options_.close_series};
  gaussian_series_->Render(input, out, keep_);
  kept_ = gaussian_series_.get();
}

void BandRenderer::Render(const BandOptics& band, const std::vector<LocalTotals>& totals,
                          const FilterWidth& width, const ParameterMaps& maps,
                          const PlaneF* junction_absorbance, double base_absorbance, const PlaneF* light,
                          bool keep, PlaneF& out) {
  keep_ = keep;
  SetTransmittance(junction_absorbance, base_absorbance);
  if (!options_.full_band_integration) {
    RenderNode(band, band.center, totals[band.center], maps, light, out);
    if (keep) center_reflectance_ = out;
    width.Multiply({maps, mu_a_epidermis_, mu_a_dermis_, transmittance_}, out);
    return;
  }
  Fill(out, width_, height_, 0.0f);
  for (std::size_t node = 0; node < band.nodes.size(); ++node) {
    RenderNode(band, static_cast<int>(node), totals[node], maps, light, node_reflectance_);
    const float weight = static_cast<float>(band.nodes[node].weight);
    const TotalsCorrection& correction = band.nodes[node].tables.correction;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double ratio =
          correction
              .At(mu_a_epidermis_.data()[i], mu_a_dermis_.data()[i], -std::log(transmittance_.data()[i]))
              .value;
      out.data()[i] += weight * static_cast<float>(ratio) * node_reflectance_.data()[i];
    }
  }
}

}  // namespace dermap
