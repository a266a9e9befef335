// SPDX-License-Identifier: Apache-2.0
// The forward model: tables of all bands, the threads' renderers, closed forms.
#include "common/transport/forward_model.h"

#include <cassert>
#include <cmath>
#include <functional>
#include <mutex>
#include <numbers>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/optics/fresnel.h"
#include "common/transport/band_optics.h"
#include "common/transport/band_renderer.h"
#include "common/transport/filter_width.h"
#include "common/transport/plane_math.h"
#include "common/transport/render_checks.h"

namespace dermap {

struct ForwardModel::Impl {
  TissueConfig tissue;
  ImagingConditions conditions;
  ForwardOptions options;
  float exit_angle_factor = 1.0f;
  // Megabytes a band, shared by the models made with With().
  struct Tables {
    std::vector<BandOptics> optics;
    std::vector<std::vector<LocalTotals>> totals;  // [band][node]
    std::vector<FilterWidth> widths;               // [band]
  };
  std::shared_ptr<const Tables> tables;

  PathPlans plans;
  std::mutex mutex;
  std::vector<std::unique_ptr<BandRenderer>> idle;  // guarded by mutex

  // Derivatives of one band, until those of all bands are there.
  struct BandDerivatives {
    ParameterMaps maps;
    PlaneF junction, reflectance;
  };
  std::vector<std::vector<BandDerivatives>> idle_derivatives;  // guarded by mutex

  std::unique_ptr<BandRenderer> Take(int width, int height);
  void GiveBack(std::unique_ptr<BandRenderer> renderer);
  std::vector<BandDerivatives> TakeDerivatives();
  static const PlaneF* JunctionOf(int band, const ParameterMaps& maps);
  template <class Use>
  void RenderAnd(int band, const ParameterMaps& maps, std::span<const PlaneF> light, bool keep, PlaneF& out,
                 const Use& use);
  void RenderAll(const ParameterMaps& maps, std::span<const PlaneF> light, std::vector<PlaneF>& reflectance,
                 std::vector<BandChoice>* choices);
  void CheckDerivatives() const;
  static void SetTerms(const TissueConfig& tissue, int terms, std::vector<BandOptics>& optics);
  static void SetGaussians(int step, std::vector<BandOptics>& optics);
  std::unique_ptr<Impl> Copy(const ImagingConditions& under, const ForwardOptions& with) const;
};

std::unique_ptr<BandRenderer> ForwardModel::Impl::Take(int width, int height) {
  {
    const std::lock_guard lock(mutex);
    if (!idle.empty() && !idle.back()->Fits(width, height)) idle.clear();
    if (!idle.empty()) {
      std::unique_ptr<BandRenderer> renderer = std::move(idle.back());
      idle.pop_back();
      return renderer;
    }
  }
  return std::make_unique<BandRenderer>(width, height, conditions, options, plans);
}

std::vector<ForwardModel::Impl::BandDerivatives> ForwardModel::Impl::TakeDerivatives() {
  const std::lock_guard lock(mutex);
  if (idle_derivatives.empty()) return std::vector<BandDerivatives>(tables->optics.size());
  std::vector<BandDerivatives> taken = std::move(idle_derivatives.back());
  idle_derivatives.pop_back();
  return taken;
}

void ForwardModel::Impl::GiveBack(std::unique_ptr<BandRenderer> renderer) {
  const std::lock_guard lock(mutex);
  idle.push_back(std::move(renderer));
}

const PlaneF* ForwardModel::Impl::JunctionOf(int band, const ParameterMaps& maps) {
  const auto& planes = maps.junction_absorbance;
  return planes.empty() ? nullptr : &planes[planes.size() == 1 ? 0 : band];
}

// Renders a band and hands the renderer, which remembers it, and the reflectance to `use`.
template <class Use>
void ForwardModel::Impl::RenderAnd(int band, const ParameterMaps& maps, std::span<const PlaneF> light,
                                   bool keep, PlaneF& out, const Use& use) {
  std::unique_ptr<BandRenderer> renderer = Take(maps.width(), maps.height());
  const PlaneF* lit = light.empty() ? nullptr : &light[light.size() == 1 ? 0 : band];
  renderer->Render(tables->optics[band], tables->totals[band], tables->widths[band], maps,
                   JunctionOf(band, maps), tissue.junction_absorbance, lit, keep, out);
  if (exit_angle_factor != 1.0f) Scaled(out, exit_angle_factor, out);
  use(*renderer);
  GiveBack(std::move(renderer));
}

ForwardModel::ForwardModel(const Chromophores& chromophores, const ProfileSource& source,
                           const TissueConfig& tissue, std::span<const Band> bands,
                           const ImagingConditions& conditions, const ForwardOptions& options,
                           const ProgressFunction& progress)
    : impl_(std::make_unique<Impl>()) {
  Validate(tissue);
  CheckModelInputs(bands, conditions, options);
  impl_->tissue = tissue;
  impl_->conditions = conditions;
  impl_->options = options;
  impl_->exit_angle_factor =
      static_cast<float>(ExitAngleFactor(conditions.geometry, tissue.n_outside, tissue.n_epidermis));
  auto tables = std::make_shared<Impl::Tables>();
  tables->optics =
      BuildBandOptics(chromophores, source, tissue, bands, options.full_band_integration, progress);
  Impl::SetTerms(tissue, options.terms, tables->optics);
  if (options.gaussian_step != 1) Impl::SetGaussians(options.gaussian_step, tables->optics);
  for (const BandOptics& band : tables->optics) {
    std::vector<LocalTotals>& totals = tables->totals.emplace_back();
    for (const BandOptics::Node& node : band.nodes) totals.emplace_back(node.tables);
  }
  tables->widths.resize(bands.size());
  ParallelFor(static_cast<int>(bands.size()), [&](int band) {
    if (!options.full_band_integration) tables->widths[band] = FilterWidth(tables->optics[band]);
  });
  impl_->tables = std::move(tables);
}

void ForwardModel::Impl::SetTerms(const TissueConfig& tissue, int terms, std::vector<BandOptics>& optics) {
  for (BandOptics& band : optics)
    band.terms = terms == kAutomaticTerms ? AutomaticTerms(band, tissue) : terms;
}

void ForwardModel::Impl::SetGaussians(int step, std::vector<BandOptics>& optics) {
  for (BandOptics& band : optics)
    for (BandOptics::Node& node : band.nodes) UseFewerGaussians(step, node.tables);
}

ForwardModel::ForwardModel(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

std::unique_ptr<ForwardModel::Impl> ForwardModel::Impl::Copy(const ImagingConditions& under,
                                                             const ForwardOptions& with) const {
  std::vector<Band> bands;
  for (const BandOptics& band : tables->optics) bands.push_back(band.band);
  CheckModelInputs(bands, under, with);
  auto impl = std::make_unique<Impl>();
  impl->tissue = tissue;
  impl->conditions = under;
  impl->options = with;
  impl->exit_angle_factor =
      static_cast<float>(ExitAngleFactor(under.geometry, tissue.n_outside, tissue.n_epidermis));
  impl->tables = tables;
  if (with.terms != options.terms || with.gaussian_step != options.gaussian_step) {
    auto other = std::make_shared<Tables>(*tables);
    SetTerms(tissue, with.terms, other->optics);
    if (with.gaussian_step != options.gaussian_step) SetGaussians(with.gaussian_step, other->optics);
    impl->tables = std::move(other);
  }
  return impl;
}

ForwardModel ForwardModel::With(const ImagingConditions& conditions) const {
  return ForwardModel(impl_->Copy(conditions, impl_->options));
}

ForwardModel ForwardModel::With(const ForwardOptions& options) const {
  assert(options.full_band_integration == impl_->options.full_band_integration);
  return ForwardModel(impl_->Copy(impl_->conditions, options));
}

ForwardModel::~ForwardModel() = default;
ForwardModel::ForwardModel(ForwardModel&&) noexcept = default;

int ForwardModel::band_count() const {
  return static_cast<int>(impl_->tables->optics.size());
}
const ImagingConditions& ForwardModel::conditions() const {
  return impl_->conditions;
}
const ForwardOptions& ForwardModel::options() const {
  return impl_->options;
}
const TissueConfig& ForwardModel::tissue() const {
  return impl_->tissue;
}
const std::vector<BandOptics>& ForwardModel::optics() const {
  return impl_->tables->optics;
}

std::vector<PlaneF> ForwardModel::Render(const ParameterMaps& maps, std::span<const PlaneF> light,
                                         std::vector<BandChoice>* choices) const {
  std::vector<PlaneF> reflectance;
  impl_->RenderAll(maps, light, reflectance, choices);
  return reflectance;
}

void ForwardModel::Render(const ParameterMaps& maps, std::span<const PlaneF> light,
                          std::vector<PlaneF>& reflectance) const {
  impl_->RenderAll(maps, light, reflectance, nullptr);
}

void ForwardModel::Impl::RenderAll(const ParameterMaps& maps, std::span<const PlaneF> light,
                                   std::vector<PlaneF>& reflectance, std::vector<BandChoice>* choices) {
  const int bands = static_cast<int>(tables->optics.size());
  if (choices) choices->assign(bands, {});
  CheckMaps(maps, bands);
  CheckLight(light, maps, bands);
  reflectance.resize(bands);
  const auto render = [&](int band) {
    RenderAnd(band, maps, light, false, reflectance[band], [&](const BandRenderer& renderer) {
      if (choices) (*choices)[band] = renderer.choice();
    });
  };
  ParallelFor(bands, std::cref(render));  // a reference: a function of its own would take memory
}

PlaneF ForwardModel::RenderBand(int band, const ParameterMaps& maps, const PlaneF* light) const {
  assert(band >= 0 && band < band_count());
  CheckMaps(maps, band_count());
  const std::span<const PlaneF> lights{light, light ? std::size_t{1} : std::size_t{0}};
  CheckLight(lights, maps, band_count());
  PlaneF reflectance;
  impl_->RenderAnd(band, maps, lights, false, reflectance, [](const BandRenderer&) {});
  return reflectance;
}

void ForwardModel::Impl::CheckDerivatives() const {
  if (!options.full_band_integration) return;
  throw InputError(
      "derivatives of a render are those of one wavelength a band, but full-band integration was asked for; "
      "remedy: leave it out");
}

std::vector<PlaneF> ForwardModel::Tangent(const ParameterMaps& maps, const ParameterMaps& change,
                                          std::span<const PlaneF> light) const {
  impl_->CheckDerivatives();
  CheckMaps(maps, band_count());
  CheckLight(light, maps, band_count());
  std::vector<PlaneF> changes(band_count());
  ParallelFor(band_count(), [&](int band) {
    PlaneF reflectance;
    impl_->RenderAnd(band, maps, light, true, reflectance, [&](BandRenderer& renderer) {
      renderer.Tangent(impl_->tables->optics[band], impl_->tables->widths[band], maps, change,
                       Impl::JunctionOf(band, change), changes[band]);
      Scaled(changes[band], impl_->exit_angle_factor, changes[band]);
    });
  });
  return changes;
}

ForwardModel::Kept::Kept(const ForwardModel& model, const ParameterMaps& maps)
    : model_(model), maps_(maps), renderers_(model.band_count()) {
  Impl& impl = *model.impl_;
  impl.CheckDerivatives();
  CheckMaps(maps, model.band_count());
  ParallelFor(model.band_count(), [&](int band) {
    renderers_[band] = impl.Take(maps.width(), maps.height());
    PlaneF reflectance;
    renderers_[band]->Render(impl.tables->optics[band], impl.tables->totals[band], impl.tables->widths[band],
                             maps, Impl::JunctionOf(band, maps), impl.tissue.junction_absorbance, nullptr,
                             true, reflectance);
  });
}

ForwardModel::Kept::~Kept() = default;

std::vector<PlaneF> ForwardModel::Kept::Tangent(const ParameterMaps& change) const {
  const Impl& impl = *model_.impl_;
  std::vector<PlaneF> changes(renderers_.size());
  ParallelFor(model_.band_count(), [&](int band) {
    renderers_[band]->Tangent(impl.tables->optics[band], impl.tables->widths[band], maps_, change,
                              Impl::JunctionOf(band, change), changes[band]);
    Scaled(changes[band], impl.exit_angle_factor, changes[band]);
  });
  return changes;
}

ParameterMaps ForwardModel::Transpose(const ParameterMaps& maps, const WeighFunction& weigh,
                                      std::span<const PlaneF> light) const {
  impl_->CheckDerivatives();
  CheckMaps(maps, band_count());
  CheckLight(light, maps, band_count());
  std::vector<Impl::BandDerivatives> by_band = impl_->TakeDerivatives();
  ParallelFor(band_count(), [&](int band) {
    Impl::BandDerivatives& by = by_band[band];
    impl_->RenderAnd(band, maps, light, true, by.reflectance, [&](BandRenderer& renderer) {
      PlaneF weights = weigh(band, by.reflectance);
      Scaled(weights, impl_->exit_angle_factor, weights);
      renderer.Transpose(impl_->tables->optics[band], impl_->tables->widths[band], maps, weights, by.maps,
                         by.junction);
    });
  });
  ParameterMaps sum;  // in the bands' order: the same for any number of threads
  sum.planes = by_band[0].maps.planes;
  for (int band = 1; band < band_count(); ++band)
    for (int k = 0; k < kParameterCount; ++k) AddTo(by_band[band].maps.planes[k], sum.planes[k]);
  const std::size_t junctions = maps.junction_absorbance.size();
  for (int band = 0; band < band_count() && junctions > 0; ++band) {
    if (junctions > 1 || band == 0) {
      sum.junction_absorbance.push_back(by_band[band].junction);
    } else {
      AddTo(by_band[band].junction, sum.junction_absorbance[0]);
    }
  }
  const std::lock_guard lock(impl_->mutex);
  impl_->idle_derivatives.push_back(std::move(by_band));
  return sum;
}

double ForwardModel::LocalReflectance(int band, const ParameterVector& p, double junction_absorbance) const {
  assert(band >= 0 && band < band_count());
  double reflectance = 0.0;
  for (const BandOptics::Node& node : impl_->tables->optics[band].nodes) {
    reflectance += node.weight * node.tables
                                     .CorrectedDerivatives(node.absorbers.MuAEpidermis(p),
                                                           node.absorbers.MuADermis(p), junction_absorbance)
                                     .reflectance;
  }
  return impl_->exit_angle_factor * reflectance;
}

double ForwardModel::LocalReflectance(int band, const ParameterVector& p, double junction_absorbance,
                                      ParameterVector& gradient) const {
  assert(band >= 0 && band < band_count());
  double reflectance = 0.0;
  gradient.fill(0.0);
  for (const BandOptics::Node& node : impl_->tables->optics[band].nodes) {
    const auto total = node.tables.CorrectedDerivatives(node.absorbers.MuAEpidermis(p),
                                                        node.absorbers.MuADermis(p), junction_absorbance);
    const ParameterVector epidermis = node.absorbers.MuAEpidermisGradient(p);
    const ParameterVector dermis = node.absorbers.MuADermisGradient(p);
    const double weight = node.weight * impl_->exit_angle_factor;
    reflectance += weight * total.reflectance;
    for (int k = 0; k < kParameterCount; ++k) {
      gradient[k] += weight * (total.d_mu_a_epidermis * epidermis[k] + total.d_mu_a_dermis * dermis[k]);
    }
  }
  return reflectance;
}

LogSensitivity ForwardModel::LocalSensitivity(int band, const ParameterVector& p,
                                              double junction_absorbance) const {
  assert(band >= 0 && band < band_count());
  const BandOptics::Node& node = impl_->tables->optics[band].nodes[impl_->tables->optics[band].center];
  const auto total = node.tables.TotalReflectanceDerivatives(
      node.absorbers.MuAEpidermis(p), node.absorbers.MuADermis(p), junction_absorbance);
  return {total.d_mu_a_epidermis / total.reflectance, total.d_mu_a_dermis / total.reflectance,
          total.d_junction_absorbance / total.reflectance};
}

double ExitAngleFactor(Geometry geometry, double n_outside, double n_skin) {
  if (geometry == Geometry::kHemispherical) return 1.0;
  // By reciprocity what leaves in a direction is what would enter from it.
  const double cos_view = std::cos(std::numbers::pi / 6.0);
  return (1.0 - FresnelReflectance(cos_view, n_outside, n_skin)) /
         (1.0 - DiffuseFresnelReflectance(n_outside, n_skin));
}

}  // namespace dermap
