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
constexpr double kLeast = 1e-280;  // stands for a ballistic share that has vanished
// Of diffuse light so little is noise of the solver, or has underflowed (a thick, dark layer): neither its
// logarithm nor its shape says anything, and nobody sees it.
constexpr double kLeastDiffuse = 1e-16;

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

// Lagrange's weights of the nodes nearest to x; nodes ascend.
SampledSource::Stencil SampledSource::StencilAmong(const std::vector<double>& nodes, double x) {
  const int count = static_cast<int>(nodes.size());
  const int above = static_cast<int>(std::upper_bound(nodes.begin(), nodes.end(), x) - nodes.begin());
  Stencil stencil{};
  stencil.first = std::clamp(above - kStencil / 2, 0, count - kStencil);
  const double* near = nodes.data() + stencil.first;
  for (int i = 0; i < kStencil; ++i) {
    double weight = 1.0;
    for (int j = 0; j < kStencil; ++j) {
      if (j != i) weight *= (x - near[j]) / (near[i] - near[j]);
    }
    stencil.weights[i] = weight;
  }
  return stencil;
}

void SampledSource::Sampled::Append(std::span<const double> transform) {
  const bool vanished = !(transform[0] > kLeastDiffuse);
  const double total = vanished ? kLeastDiffuse : transform[0];
  log_total.push_back(std::log(total));
  auto& ratios = shape.emplace_back();
  for (const double value : transform) ratios.push_back(vanished ? 1.0 : value / total);
  ratios[0] = 1.0;
}

SampledSource::SampledSource(const ProfileSource& source, const EpidermisOptics& epidermis,
                             const DermisOptics& dermis, std::span<const double> k_per_mm, double min_mu_a,
                             double max_mu_a)
    : name_(source.Name()),
      epidermis_(epidermis),
      dermis_(dermis),
      k_per_mm_(k_per_mm.begin(), k_per_mm.end()),
      log_min_(std::log(min_mu_a)),
      log_step_(std::log(max_mu_a / min_mu_a) / (kSamples - 1)) {
  assert(!k_per_mm_.empty() && k_per_mm_[0] == 0.0);
  std::vector<double> sampled_k{0.0};
  if (k_per_mm_.size() <= 2 * kStencil) {
    sampled_k = k_per_mm_;
  } else {
    for (std::size_t i = 1; i < k_per_mm_.size(); i += 2) sampled_k.push_back(k_per_mm_[i]);
    if (sampled_k.back() != k_per_mm_.back()) sampled_k.push_back(k_per_mm_.back());
  }
  Sample(source, sampled_k);
  if (sampled_k.size() == k_per_mm_.size()) return;
  for (Sampled* sampled :
       {&r_forward_, &t_forward_, &r_backward_, &t_backward_, &black_, &r_single_, &r_diffuse_, &r_normal_}) {
    Refine(*sampled, sampled_k);
  }
}

void SampledSource::Sample(const ProfileSource& source, std::span<const double> sampled_k) {
  std::vector<EpidermisTransforms> open(kSamples), black(kSamples);
  std::vector<DermisTransforms> below(kSamples);
  ParallelFor(3 * kSamples, [&](int task) {
    const int i = task / 3;
    EpidermisOptics upper = epidermis_;
    DermisOptics lower = dermis_;
    upper.layer.mu_a = lower.layer.mu_a = std::exp(log_min_ + i * log_step_);
    upper.black_above = task % 3 == 1;
    if (task % 3 == 0) open[i] = source.Epidermis(upper, sampled_k);
    if (task % 3 == 1) black[i] = source.Epidermis(upper, sampled_k);
    if (task % 3 == 2) below[i] = source.Dermis(lower, sampled_k);
  });
  for (int i = 0; i < kSamples; ++i) {
    r_forward_.Append(open[i].r_forward);
    t_forward_.Append(open[i].t_forward);
    r_backward_.Append(open[i].r_backward);
    t_backward_.Append(open[i].t_backward);
    black_.Append(black[i].r_backward);
    if (!open[i].r_single.empty()) r_single_.Append(open[i].r_single);
    r_diffuse_.Append(below[i].r_diffuse);
    r_normal_.Append(below[i].r_normal);
    log_ballistic_.push_back(LogOfShare(open[i].t_ballistic));
  }
}

// From the sampled frequencies to all.
void SampledSource::Refine(Sampled& sampled, std::span<const double> sampled_k) const {
  std::vector<double> log_k;  // without 0
  for (const double k : sampled_k.subspan(1)) log_k.push_back(std::log(k));
  std::vector<std::vector<double>> refined(sampled.shape.size(), std::vector<double>(k_per_mm_.size(), 1.0));
  for (std::size_t j = 1; j < k_per_mm_.size(); ++j) {
    const Stencil stencil = StencilAmong(log_k, std::log(k_per_mm_[j]));
    for (std::size_t sample = 0; sample < refined.size(); ++sample) {
      double value = 0.0;
      for (int i = 0; i < kStencil; ++i)
        value += stencil.weights[i] * sampled.shape[sample][1 + stencil.first + i];
      refined[sample][j] = value;
    }
  }
  sampled.shape = std::move(refined);
}

SampledSource::Stencil SampledSource::StencilAt(double mu_a) const {
  std::vector<double> nodes(kSamples);
  for (int i = 0; i < kSamples; ++i) nodes[i] = log_min_ + i * log_step_;
  return StencilAmong(nodes, std::clamp(std::log(std::max(mu_a, kLeast)), nodes.front(), nodes.back()));
}

std::vector<double> SampledSource::Interpolated(const Sampled& sampled, const Stencil& stencil) const {
  double log_total = 0.0;
  std::vector<double> transform(k_per_mm_.size(), 0.0);
  for (int i = 0; i < kStencil; ++i) {
    log_total += stencil.weights[i] * sampled.log_total[stencil.first + i];
    const std::vector<double>& shape = sampled.shape[stencil.first + i];
    for (std::size_t k = 0; k < k_per_mm_.size(); ++k) transform[k] += stencil.weights[i] * shape[k];
  }
  const double total = std::exp(log_total);
  for (double& value : transform) value *= total;
  return transform;
}

EpidermisTransforms SampledSource::Epidermis(const EpidermisOptics& optics,
                                             std::span<const double> k_per_mm) const {
  assert(SameBut(optics.layer, epidermis_.layer) && optics.thickness_mm == epidermis_.thickness_mm &&
         optics.n_above == epidermis_.n_above && optics.n_below == epidermis_.n_below &&
         k_per_mm.size() == k_per_mm_.size());
  static_cast<void>(k_per_mm);
  const Stencil stencil = StencilAt(optics.layer.mu_a);
  double log_ballistic = 0.0;
  for (int i = 0; i < kStencil; ++i) log_ballistic += stencil.weights[i] * log_ballistic_[stencil.first + i];
  return {.r_forward = Interpolated(r_forward_, stencil),
          .t_forward = Interpolated(t_forward_, stencil),
          .r_backward = Interpolated(optics.black_above ? black_ : r_backward_, stencil),
          .t_backward = Interpolated(t_backward_, stencil),
          .t_ballistic = std::exp(log_ballistic),
          .r_single = r_single_.log_total.empty() ? std::vector<double>{} : Interpolated(r_single_, stencil)};
}

DermisTransforms SampledSource::Dermis(const DermisOptics& optics, std::span<const double> k_per_mm) const {
  assert(SameBut(optics.layer, dermis_.layer) && optics.n_above == dermis_.n_above &&
         k_per_mm.size() == k_per_mm_.size());
  static_cast<void>(k_per_mm);
  const Stencil stencil = StencilAt(optics.layer.mu_a);
  return {.r_diffuse = Interpolated(r_diffuse_, stencil), .r_normal = Interpolated(r_normal_, stencil)};
}

}  // namespace dermap
