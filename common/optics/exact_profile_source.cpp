// SPDX-License-Identifier: Apache-2.0
// From layers in mm to the optical units of exact_layer.h, frequency by frequency.
#include "common/optics/exact_profile_source.h"

#include "common/optics/exact_layer.h"
#include "common/optics/fresnel.h"

namespace dermap {
namespace {

double Extinction(const LayerOptics& layer) {
  return layer.mu_a + layer.mu_s_reduced;
}

ExactResponses SolveEpidermis(const EpidermisOptics& optics, const ExactFaces& faces, double k_per_mm) {
  const double mu_t = Extinction(optics.layer);
  return SolveExactLayer(faces, optics.thickness_mm * mu_t, optics.layer.mu_s_reduced / mu_t,
                         k_per_mm / mu_t);
}

ExactFaces FacesOf(const EpidermisOptics& optics) {
  return MakeExactFaces(optics.n_above, optics.layer.n, optics.n_below, optics.black_above, false);
}

// Share of light along the normal that passes the skin's surface.
double Entering(const EpidermisOptics& optics) {
  return 1.0 - FresnelReflectance(1.0, optics.n_above, optics.layer.n);
}

}  // namespace

EpidermisTransforms ExactProfileSource::Epidermis(const EpidermisOptics& optics,
                                                  std::span<const double> k_per_mm) const {
  const ExactFaces faces = FacesOf(optics);
  const double entering = Entering(optics);
  EpidermisTransforms transforms;
  for (const double k : k_per_mm) {
    const ExactResponses r = SolveEpidermis(optics, faces, k);
    transforms.r_forward.push_back(entering * (r.r_normal + r.r_ballistic));
    transforms.t_forward.push_back(entering * r.t_normal);
    transforms.r_backward.push_back(r.r_up);
    transforms.t_backward.push_back(r.t_up);
    transforms.r_single.push_back(entering * r.r_normal_single);
    transforms.t_ballistic = entering * r.t_ballistic;
  }
  return transforms;
}

DermisTransforms ExactProfileSource::Dermis(const DermisOptics& optics,
                                            std::span<const double> k_per_mm) const {
  const ExactFaces faces = MakeExactFaces(optics.n_above, optics.layer.n, optics.layer.n, false, true);
  const double mu_t = Extinction(optics.layer);
  DermisTransforms transforms;
  for (const double k : k_per_mm) {
    const ExactResponses r = SolveExactLayer(faces, 0.0, optics.layer.mu_s_reduced / mu_t, k / mu_t);
    transforms.r_diffuse.push_back(r.r_down);
    transforms.r_normal.push_back(r.r_normal);
  }
  return transforms;
}

}  // namespace dermap
