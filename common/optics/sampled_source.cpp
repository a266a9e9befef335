// SPDX-License-Identifier: Apache-2.0
// Samples over log mu_a, and Lagrange's interpolation between them.
#include "common/optics/sampled_source.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr int kStencil = 6;
constexpr double kLeast = 1e-280;  // stands for a share that has vanished

double LogOfShare(double share) {
  return std::log(std::max(share, kLeast));
}

[[maybe_unused]] bool SameBut(const LayerOptics& a, const LayerOptics& b) {
  return a.mu_s_reduced == b.mu_s_reduced && a.n == b.n;
}

}  // namespace

struct SampledSource::Stencil {
  int first;
  std::array<double, kStencil> weights;
};

void SampledSource::Sampled::Append(std::span<const double> transform) {
  const double total = std::max(transform[0], kLeast);
  log_total.push_back(std::log(total));
  auto& ratios = shape.emplace_back();
  for (const double value : transform) ratios.push_back(value / total);
  ratios[0] = 1.0;
}

SampledSource::SampledSource(const ProfileSource& source, const EpidermisOptics& epidermis,
                             const DermisOptics& dermis, std::span<const double> k_per_mm, double min_mu_a,
                             double max_mu_a)
    : name_(source.Name()),
      epidermis_(epidermis),
      dermis_(dermis),
      frequency_count_(k_per_mm.size()),
      log_min_(std::log(min_mu_a)),
      log_step_(std::log(max_mu_a / min_mu_a) / (kSamples - 1)) {
  assert(!k_per_mm.empty() && k_per_mm[0] == 0.0);
  std::vector<EpidermisTransforms> open(kSamples), black(kSamples);
  std::vector<DermisTransforms> below(kSamples);
  ParallelFor(3 * kSamples, [&](int task) {
    const int i = task / 3;
    const double mu_a = std::exp(log_min_ + i * log_step_);
    EpidermisOptics upper = epidermis;
    DermisOptics lower = dermis;
    upper.layer.mu_a = lower.layer.mu_a = mu_a;
    upper.black_above = task % 3 == 1;
    if (task % 3 == 0) open[i] = source.Epidermis(upper, k_per_mm);
    if (task % 3 == 1) black[i] = source.Epidermis(upper, k_per_mm);
    if (task % 3 == 2) below[i] = source.Dermis(lower, k_per_mm);
  });
  for (int i = 0; i < kSamples; ++i) {
    r_forward_.Append(open[i].r_forward);
    t_forward_.Append(open[i].t_forward);
    r_backward_.Append(open[i].r_backward);
    t_backward_.Append(open[i].t_backward);
    black_.Append(black[i].r_backward);
    r_diffuse_.Append(below[i].r_diffuse);
    r_normal_.Append(below[i].r_normal);
    log_ballistic_.push_back(LogOfShare(open[i].t_ballistic));
  }
}

SampledSource::Stencil SampledSource::StencilAt(double mu_a) const {
  const double position =
      std::clamp((std::log(std::max(mu_a, kLeast)) - log_min_) / log_step_, 0.0, kSamples - 1.0);
  Stencil stencil{};
  stencil.first = std::clamp(static_cast<int>(position) - kStencil / 2 + 1, 0, kSamples - kStencil);
  for (int i = 0; i < kStencil; ++i) {
    double weight = 1.0;
    for (int j = 0; j < kStencil; ++j) {
      if (j != i) weight *= (position - stencil.first - j) / (i - j);
    }
    stencil.weights[i] = weight;
  }
  return stencil;
}

std::vector<double> SampledSource::Interpolated(const Sampled& sampled, const Stencil& stencil) const {
  double log_total = 0.0;
  std::vector<double> transform(frequency_count_, 0.0);
  for (int i = 0; i < kStencil; ++i) {
    log_total += stencil.weights[i] * sampled.log_total[stencil.first + i];
    const std::vector<double>& shape = sampled.shape[stencil.first + i];
    for (std::size_t k = 0; k < frequency_count_; ++k) transform[k] += stencil.weights[i] * shape[k];
  }
  const double total = std::exp(log_total);
  for (double& value : transform) value *= total;
  return transform;
}

EpidermisTransforms SampledSource::Epidermis(const EpidermisOptics& optics,
                                             std::span<const double> k_per_mm) const {
  assert(SameBut(optics.layer, epidermis_.layer) && optics.thickness_mm == epidermis_.thickness_mm &&
         optics.n_above == epidermis_.n_above && optics.n_below == epidermis_.n_below &&
         k_per_mm.size() == frequency_count_);
  static_cast<void>(k_per_mm);
  const Stencil stencil = StencilAt(optics.layer.mu_a);
  double log_ballistic = 0.0;
  for (int i = 0; i < kStencil; ++i) log_ballistic += stencil.weights[i] * log_ballistic_[stencil.first + i];
  return {.r_forward = Interpolated(r_forward_, stencil),
          .t_forward = Interpolated(t_forward_, stencil),
          .r_backward = Interpolated(optics.black_above ? black_ : r_backward_, stencil),
          .t_backward = Interpolated(t_backward_, stencil),
          .t_ballistic = std::exp(log_ballistic)};
}

DermisTransforms SampledSource::Dermis(const DermisOptics& optics, std::span<const double> k_per_mm) const {
  assert(SameBut(optics.layer, dermis_.layer) && optics.n_above == dermis_.n_above &&
         k_per_mm.size() == frequency_count_);
  static_cast<void>(k_per_mm);
  const Stencil stencil = StencilAt(optics.layer.mu_a);
  return {.r_diffuse = Interpolated(r_diffuse_, stencil), .r_normal = Interpolated(r_normal_, stencil)};
}

}  // namespace dermap
