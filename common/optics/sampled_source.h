// SPDX-License-Identifier: Apache-2.0
// A costly source of profiles, asked at a few absorptions only: what lies between is interpolated.
#pragma once

#include <vector>

#include "common/optics/profile_source.h"

namespace dermap {

// Responses are smooth in log mu_a, since absorption acts on path lengths as a Laplace transform, and in log
// k: the logarithm of a total and the ratio transform / total are interpolated by polynomials of degree 5
// through the nearest samples (32 absorptions, every second frequency).
class SampledSource : public ProfileSource {
 public:
  // Samples both layers, and the epidermis under black tape, at every k; in parallel. mu_a of the prototypes
  // is ignored.
  SampledSource(const ProfileSource& source, const EpidermisOptics& epidermis, const DermisOptics& dermis,
                std::span<const double> k_per_mm, double min_mu_a, double max_mu_a);

  std::string_view Name() const override { return name_; }
  // Only for the prototypes at another mu_a (clamped to the sampled range), at the sampled k.
  EpidermisTransforms Epidermis(const EpidermisOptics& optics,
                                std::span<const double> k_per_mm) const override;
  DermisTransforms Dermis(const DermisOptics& optics, std::span<const double> k_per_mm) const override;

 private:
  static constexpr int kSamples = 32;
  // One response at all samples: log of the total, and the transform over the total.
  struct Sampled {
    std::vector<double> log_total;
    std::vector<std::vector<double>> shape;
    void Append(std::span<const double> transform);
  };
  struct Stencil;  // neighbours of a point, and their shares in it
  std::string_view name_;
  EpidermisOptics epidermis_;
  DermisOptics dermis_;
  std::vector<double> k_per_mm_;
  double log_min_, log_step_;
  Sampled r_forward_, t_forward_, r_backward_, t_backward_, black_, r_single_, r_diffuse_, r_normal_;
  std::vector<double> log_ballistic_;

  void Sample(const ProfileSource& source, std::span<const double> sampled_k);
  void Refine(Sampled& sampled, std::span<const double> sampled_k) const;
  static Stencil StencilAmong(const std::vector<double>& nodes, double x);
  Stencil StencilAt(double mu_a) const;
  std::vector<double> Interpolated(const Sampled& sampled, const Stencil& stencil) const;
};

}  // namespace dermap
