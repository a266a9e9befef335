// SPDX-License-Identifier: Apache-2.0
// Lagrange's interpolation over scattering and neighbour, that of sampled_source.h over absorption.
#include "common/optics/radial_family.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/optics/radial_profile.h"
#include "common/optics/sampled_source.h"

namespace dermap {
namespace {

constexpr std::size_t kWorthwhile = 1500;  // rows: fewer are solved in the time that the nodes take
constexpr int kNeighbours = 4;
// Nodes of scattering, by greatest over smallest: visible light spans a factor of 2, 350 to 1000 nm one
// of 5.4.
constexpr int kFewScatterings = 4, kManyScatterings = 6;
constexpr double kWideScattering = 3.0, kWidestScattering = 6.0;
constexpr double kLeastMuA = 1e-3;  // 1/mm; clearer layers are solved by themselves
// 1/mm; so are darker ones, whose R(r) falls so fast that an interpolated transform does not hold it (but
// which are quickly solved).
constexpr double kMostMuA = 20.0;

// Chebyshev's nodes on [low, high], or the values themselves where they are few.
std::vector<double> Nodes(std::vector<double> values, int count) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (static_cast<int>(values.size()) <= count) return values;
  std::vector<double> nodes;
  const double middle = 0.5 * (values.front() + values.back()), half = 0.5 * (values.back() - values.front());
  for (int i = 0; i < count; ++i)
    nodes.push_back(middle - half * std::cos(std::numbers::pi * (i + 0.5) / count));
  return nodes;
}

std::vector<double> LagrangeWeights(const std::vector<double>& nodes, double x) {
  std::vector<double> weights;
  for (const double node : nodes) {
    double weight = 1.0;
    for (const double other : nodes) {
      if (other != node) weight *= (x - other) / (node - other);
    }
    weights.push_back(weight);
  }
  return weights;
}

void AddTimes(const std::vector<double>& from, double weight, std::vector<double>& to) {
  to.resize(from.size(), 0.0);
  for (std::size_t i = 0; i < from.size(); ++i) to[i] += weight * from[i];
}

bool IsFamily(std::span<const SkinRow> rows) {
  const SkinRow& first = rows.front();
  const double ratio = first.mu_s_reduced_dermis / first.mu_s_reduced_epidermis;
  return std::all_of(rows.begin(), rows.end(), [&](const SkinRow& row) {
    return row.epidermis_thickness_mm == first.epidermis_thickness_mm &&
           std::abs(row.mu_s_reduced_dermis - ratio * row.mu_s_reduced_epidermis) <
               1e-9 * row.mu_s_reduced_dermis;
  });
}

}  // namespace

struct RadialFamily::Node {
  EpidermisOptics upper;
  DermisOptics lower;
  SampledSource sampled;
};

RadialFamily::~RadialFamily() = default;

std::unique_ptr<const RadialFamily> RadialFamily::Of(std::span<const SkinRow> rows,
                                                     const ProfileSource& source,
                                                     const TissueConfig& config) {
  if (rows.size() < kWorthwhile || !IsFamily(rows)) return nullptr;
  std::vector<double> log_scattering;
  double low = 1e300, high = 0.0;
  for (const SkinRow& row : rows) {
    log_scattering.push_back(std::log(row.mu_s_reduced_epidermis));
    low = std::min({low, row.mu_a_epidermis, row.mu_a_dermis});
    high = std::max({high, std::min(row.mu_a_epidermis, kMostMuA), row.mu_a_dermis});
  }
  const auto [least, most] = std::minmax_element(log_scattering.begin(), log_scattering.end());
  const double spread = std::exp(*most - *least);
  if (spread > kWidestScattering) return nullptr;
  const double most_scattering = std::exp(*most);

  std::unique_ptr<RadialFamily> family(new RadialFamily);
  family->min_mu_a_ = std::max(low, kLeastMuA);
  family->max_mu_a_ = std::max(high, 1.5 * family->min_mu_a_);
  const auto k = RadialProfile::Frequencies_per_mm(family->max_mu_a_ + most_scattering);
  family->k_per_mm_.assign(k.begin(), k.end());
  family->log_scattering_ =
      Nodes(log_scattering, spread > kWideScattering ? kManyScatterings : kFewScatterings);
  const double log_low = std::log(family->min_mu_a_), log_high = std::log(family->max_mu_a_);
  family->log_neighbour_ = Nodes({log_low, log_high, 0.3 * log_low + 0.7 * log_high,
                                  0.5 * (log_low + log_high), 0.7 * log_low + 0.3 * log_high},
                                 kNeighbours);
  const double ratio = rows.front().mu_s_reduced_dermis / rows.front().mu_s_reduced_epidermis;
  for (const double log_mu_s : family->log_scattering_) {
    for (const double log_mu_a : family->log_neighbour_) {
      const double mu_s = std::exp(log_mu_s), mu_a = std::exp(log_mu_a);
      const EpidermisOptics upper{.layer = {0.0, mu_s, config.n_epidermis},
                                  .thickness_mm = rows.front().epidermis_thickness_mm,
                                  .n_above = config.n_outside,
                                  .n_below = config.n_dermis,
                                  .dermis = {mu_a, ratio * mu_s}};
      const DermisOptics lower{.layer = {0.0, ratio * mu_s, config.n_dermis},
                               .n_above = config.n_epidermis,
                               .epidermis = {mu_a, mu_s},
                               .epidermis_thickness_mm = rows.front().epidermis_thickness_mm};
      family->nodes_.push_back(std::unique_ptr<const Node>(new Node{
          upper, lower, SampledSource(source, upper, lower, k, family->min_mu_a_, family->max_mu_a_)}));
    }
  }
  return family;
}

bool RadialFamily::Holds(const SkinRow& row) const {
  return row.mu_a_epidermis >= min_mu_a_ && row.mu_a_epidermis <= kMostMuA && row.mu_a_dermis >= min_mu_a_;
}

RadialFamily::Transforms RadialFamily::At(const SkinRow& row) const {
  const auto by_scattering = LagrangeWeights(log_scattering_, std::log(row.mu_s_reduced_epidermis));
  const auto by_dermis = LagrangeWeights(log_neighbour_, std::log(row.mu_a_dermis));
  const auto by_epidermis = LagrangeWeights(log_neighbour_, std::log(row.mu_a_epidermis));
  Transforms sum;
  for (std::size_t s = 0; s < by_scattering.size(); ++s) {
    for (std::size_t n = 0; n < by_dermis.size(); ++n) {
      const Node& node = *nodes_[s * by_dermis.size() + n];
      EpidermisOptics upper = node.upper;
      upper.layer.mu_a = row.mu_a_epidermis;
      const EpidermisTransforms e = node.sampled.Epidermis(upper, k_per_mm_);
      const double upper_weight = by_scattering[s] * by_dermis[n];
      AddTimes(e.r_forward, upper_weight, sum.epidermis.r_forward);
      AddTimes(e.t_forward, upper_weight, sum.epidermis.t_forward);
      AddTimes(e.r_backward, upper_weight, sum.epidermis.r_backward);
      AddTimes(e.t_backward, upper_weight, sum.epidermis.t_backward);
      AddTimes(e.r_single, upper_weight, sum.epidermis.r_single);
      sum.epidermis.t_ballistic += upper_weight * e.t_ballistic;
      DermisOptics lower = node.lower;
      lower.layer.mu_a = row.mu_a_dermis;
      const DermisTransforms d = node.sampled.Dermis(lower, k_per_mm_);
      const double lower_weight = by_scattering[s] * by_epidermis[n];
      AddTimes(d.r_diffuse, lower_weight, sum.dermis.r_diffuse);
      AddTimes(d.r_normal, lower_weight, sum.dermis.r_normal);
    }
  }
  return sum;
}

}  // namespace dermap
