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
      domain, MakeConvolver(options.engine, domain, conditions.pixel_size_mm, BorderOf(conditions)));
}

void BandRenderer::SetLight(const PlaneF* light, const Domain& domain) {
  const PlaneF ones = light ? PlaneF() : PlaneF(width_, height_, 1.0f);
  const PlaneF& patch = light ? *light : ones;
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
    path_light_ = nullptr;
    EnsureShape(out, width_, height_);
    local_light_ = light ? light->data()[0] : 1.0f;
    for (std::size_t i = 0; i < out.size(); ++i)
      out.data()[i] = local_light_ * totals.Reflectance(PositionInTable(mu_a_epidermis_.data()[i]),
                                                        PositionInTable(mu_a_dermis_.data()[i]),
                                                        transmittance_.data()[i]);
    return;
  }
  path_light_ = &LightWithMargin(choice_.margin_mm);
  SetLight(light, path_light_->domain());
  const SeriesInput input{optics.tables,   totals,        optics.mu_s_epidermis, optics.mu_s_dermis,
                          mu_a_epidermis_, mu_a_dermis_,  transmittance_,        light_,
                          black_tape,      choice_.terms, options_.close_series};
  choice_.margin_mm = path_light_->margin_mm();
  path_light_->Render(input, plans_, keep_, out);
  AddPaths(path_light_->plan(), path_light_->frames(), options_.tolerance, choice_);
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
  gaussian_series_->Render(input, out);
}

PlaneF BandRenderer::Render(const BandOptics& band, const std::vector<LocalTotals>& totals,
                            const FilterWidth& width, const ParameterMaps& maps,
                            const PlaneF* junction_absorbance, double base_absorbance, const PlaneF* light,
                            bool keep) {
  keep_ = keep;
  SetTransmittance(junction_absorbance, base_absorbance);
  PlaneF out(width_, height_);
  if (!options_.full_band_integration) {
    RenderNode(band, band.center, totals[band.center], maps, light, out);
    if (!gaussian_series_) center_reflectance_ = out;
    width.Multiply({maps, mu_a_epidermis_, mu_a_dermis_, transmittance_}, out);
    return out;
  }
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
  return out;
}

namespace {

// change of mu_a += d mu_a / d p * change of p, for the parameters that change.
void AddAbsorptionChange(const Absorbers& a, const ParameterMaps& maps, const ParameterMaps& change,
                         PathLight::Changes& mu_a) {
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
void AddAbsorptionDerivatives(const Absorbers& a, const ParameterMaps& maps, const PathLight::Changes& by,
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

void BandRenderer::LocalTangent(const BandOptics& band, const PathLight::Changes& changes,
                                PlaneF& out) const {
  out = PlaneF(width_, height_);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::array<double, 3> by = LocalDerivatives(band, i);
    for (int k = 0; k < 3; ++k)
      if (!changes[k].empty()) out.data()[i] += static_cast<float>(by[k] * changes[k].data()[i]);
  }
}

void BandRenderer::LocalTranspose(const BandOptics& band, const PlaneF& weights,
                                  PathLight::Changes& derivatives) const {
  for (PlaneF& plane : derivatives) plane = PlaneF(width_, height_);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const std::array<double, 3> by = LocalDerivatives(band, i);
    for (int k = 0; k < 3; ++k) derivatives[k].data()[i] = static_cast<float>(by[k] * weights.data()[i]);
  }
}

PlaneF BandRenderer::Tangent(const BandOptics& band, const FilterWidth& width, const ParameterMaps& maps,
                             const ParameterMaps& change, const PlaneF* junction_change) {
  const Absorbers& absorbers = band.nodes[band.center].absorbers;
  PathLight::Changes mu_a;
  mu_a[0] = mu_a[1] = PlaneF(width_, height_);
  AddAbsorptionChange(absorbers, maps, change, mu_a);
  if (junction_change) {
    mu_a[2] = *junction_change;  // A = exp(-P)
    for (std::size_t i = 0; i < mu_a[2].size(); ++i) mu_a[2].data()[i] *= -transmittance_.data()[i];
  }
  PlaneF out, ratio;
  if (path_light_) {
    path_light_->Tangent(mu_a, out);
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
  PathLight::Changes by;
  if (path_light_) {
    path_light_->Transpose(weights, by);
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
