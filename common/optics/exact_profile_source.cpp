// SPDX-License-Identifier: Apache-2.0
// From layers in mm to the optical units of exact_layer.h, frequency by frequency.
#include "common/optics/exact_profile_source.h"

#include <limits>

#include "common/optics/anisotropy.h"
#include "common/optics/exact_layer.h"
#include "common/optics/fresnel.h"

namespace dermap {
namespace {

double Extinction(const LayerOptics& layer) {
  return layer.mu_a + layer.mu_s_reduced;
}

// What diffuse light from the neighbour looks like inside `layer`; thickness_mm of the neighbour.
ExactNeighbour NeighbourOf(const LayerOptics& layer, const TypicalNeighbour& neighbour,
                           double default_scattering, double n_neighbour, double thickness_mm) {
  const double mu_s = neighbour.mu_s_reduced > 0.0 ? neighbour.mu_s_reduced : default_scattering;
  const double mu_t = neighbour.mu_a + mu_s;
  return {.extinction = mu_t / Extinction(layer),
          .albedo = mu_s / mu_t,
          .index = n_neighbour / layer.n,
          .thickness = thickness_mm * mu_t};
}

// Share of light along the normal that passes the skin's surface.
double Entering(const EpidermisOptics& optics) {
  return 1.0 - FresnelReflectance(1.0, optics.n_above, optics.layer.n);
}

}  // namespace

ExactNeighbour NeighbourBelow(const EpidermisOptics& optics) {
  return NeighbourOf(optics.layer, optics.dermis, 0.5 * optics.layer.mu_s_reduced, optics.n_below,
                     std::numeric_limits<double>::infinity());
}

ExactNeighbour NeighbourAbove(const DermisOptics& optics) {
  return NeighbourOf(optics.layer, optics.epidermis, 2.0 * optics.layer.mu_s_reduced, optics.n_above,
                     optics.epidermis_thickness_mm);
}

EpidermisTransforms ExactProfileSource::Epidermis(const EpidermisOptics& optics,
                                                  std::span<const double> k_per_mm) const {
  const LayerOptics& layer = optics.layer;
  const ExactFaces faces =
      MakeExactFaces(optics.n_above, layer.n, optics.n_below, optics.black_above, false, effort_.resolution);
  const ExactFaces bottomless =
      MakeExactFaces(optics.n_above, layer.n, layer.n, optics.black_above, true, effort_.resolution);
  const double mu_t = Extinction(layer), entering = Entering(optics);
  ExactLayer exact;
  exact.thickness = optics.thickness_mm * mu_t;
  exact.albedo = layer.mu_s_reduced / mu_t;
  exact.below = NeighbourBelow(optics);
  EpidermisTransforms transforms;
  for (const double k : k_per_mm) {
    exact.kappa = k / mu_t;
    const bool opaque =
        k > 0.0 && exact.thickness * DecayRate(exact.albedo, exact.kappa) > effort_.opaque_beyond;
    const ExactResponses r = SolveExactLayer(opaque ? bottomless : faces, exact, effort_.resolution);
    // The sharp reflection of the lower face (5e-5 of the light) leaves with what was scattered.
    transforms.r_forward.push_back(entering * (r.r_normal + r.r_ballistic));
    transforms.t_forward.push_back(entering * r.t_normal);
    transforms.r_backward.push_back(r.r_up);
    transforms.t_backward.push_back(r.t_up);
    transforms.r_single.push_back(entering * r.r_normal_single);
    if (!opaque) transforms.t_ballistic = entering * r.t_ballistic;
  }
  if (layer.anisotropy != 0.0) ApplyAnisotropy(optics, transforms);
  return transforms;
}

DermisTransforms ExactProfileSource::Dermis(const DermisOptics& optics,
                                            std::span<const double> k_per_mm) const {
  const LayerOptics& layer = optics.layer;
  const ExactFaces faces = MakeExactFaces(optics.n_above, layer.n, layer.n, false, true, effort_.resolution);
  const double mu_t = Extinction(layer);
  ExactLayer exact;
  exact.albedo = layer.mu_s_reduced / mu_t;
  exact.above = NeighbourAbove(optics);
  DermisTransforms transforms;
  for (const double k : k_per_mm) {
    exact.kappa = k / mu_t;
    const ExactResponses r = SolveExactLayer(faces, exact, effort_.resolution);
    transforms.r_diffuse.push_back(r.r_down);
    transforms.r_normal.push_back(r.r_normal);
  }
  if (layer.anisotropy != 0.0) ApplyAnisotropy(optics, transforms);
  return transforms;
}

}  // namespace dermap
