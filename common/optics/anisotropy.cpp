// SPDX-License-Identifier: Apache-2.0
// Flux matrices of one layer between its faces, lit along the normal and by its neighbour.
#include "common/optics/anisotropy.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/optics/discrete_ordinates.h"
#include "common/optics/exact_profile_source.h"
#include "common/optics/fresnel.h"

namespace dermap {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

PlaneLayer LayerOf(const LayerOptics& optics, double thickness_mm) {
  return {.mu_a = optics.mu_a,
          .mu_s = optics.mu_s_reduced / (1.0 - optics.anisotropy),
          .anisotropy = optics.anisotropy,
          .thickness_mm = thickness_mm};
}

// Light of a neighbour that has crossed the face (transmittances `passes`), as fluxes just inside the layer.
VectorXd NeighbourLight(const AngularGrid& grid, int medium, const VectorXd& passes,
                        const ExactNeighbour& neighbour) {
  VectorXd flux(grid.Size(medium));
  for (int i = 0; i < grid.Size(medium); ++i) {
    const double mu = grid.mu[medium](i);
    flux(i) = mu * grid.weight[medium](i) * passes(i) * DiffuseRadiance(neighbour, mu, 0.0, 0.0).real();
  }
  return flux / flux.sum();
}

// A layer with reflection `inside`, under a face that reflects 1 - passes: all light that meets it, once lit
// by `flux`.
VectorXd AllLight(const MatrixXd& inside, const VectorXd& passes, const VectorXd& flux) {
  const MatrixXd mirrored = (VectorXd::Ones(passes.size()) - passes).asDiagonal() * inside;
  return (MatrixXd::Identity(mirrored.rows(), mirrored.cols()) - mirrored).partialPivLu().solve(flux);
}

void Scale(std::vector<double>& values, double from, double to) {
  const double factor = from > 0.0 ? to / from : 0.0;
  for (double& value : values) value *= factor;
}

}  // namespace

EpidermisTotals SolveEpidermisTotals(const EpidermisOptics& optics) {
  enum { kOutside, kEpidermis, kDermis };
  const LayerOptics& layer = optics.layer;
  const AngularGrid grid = MakeAngularGrid(std::array{optics.n_above, layer.n, optics.n_below});
  LightOperators surface = SolveFace(grid, kOutside, kEpidermis);
  if (optics.black_above) surface.r_up.setZero();
  const LightOperators junction = SolveFace(grid, kEpidermis, kDermis);
  const LightOperators upper =
      Add(surface, SolvePlaneLayer(grid, kEpidermis, LayerOf(layer, optics.thickness_mm)));
  const LightOperators whole = Add(upper, junction);
  const double specular = FresnelReflectance(1.0, optics.n_above, layer.n);

  EpidermisTotals totals;
  totals.r_forward = whole.r_down.col(0).sum() - specular;
  totals.t_ballistic = (1.0 - specular) * junction.t_down(0, 0) *
                       std::exp(-optics.thickness_mm * (layer.mu_a + layer.mu_s_reduced));
  totals.t_forward = std::max(0.0, whole.t_down.col(0).sum() - totals.t_ballistic);
  const VectorXd passes = VectorXd::Ones(grid.Size(kEpidermis)) - junction.r_down.diagonal();
  const VectorXd up =
      AllLight(upper.r_up, passes, NeighbourLight(grid, kEpidermis, passes, NeighbourBelow(optics)));
  totals.r_backward = passes.dot(upper.r_up * up);
  totals.t_backward = (upper.t_up * up).sum();
  return totals;
}

DermisTotals SolveDermisTotals(const DermisOptics& optics) {
  enum { kEpidermis, kDermis };
  const AngularGrid grid = MakeAngularGrid(std::array{optics.n_above, optics.layer.n});
  const MatrixXd inside =
      SolvePlaneLayer(grid, kDermis, LayerOf(optics.layer, std::numeric_limits<double>::infinity())).r_down;
  const VectorXd passes =
      VectorXd::Ones(grid.Size(kDermis)) - SolveFace(grid, kEpidermis, kDermis).r_up.diagonal();
  const VectorXd diffuse =
      AllLight(inside, passes, NeighbourLight(grid, kDermis, passes, NeighbourAbove(optics)));
  const VectorXd normal = AllLight(inside, passes, VectorXd::Unit(grid.Size(kDermis), 0));
  return {.r_diffuse = passes.dot(inside * diffuse), .r_normal = passes.dot(inside * normal)};
}

void ApplyAnisotropy(const EpidermisOptics& optics, EpidermisTransforms& transforms) {
  EpidermisOptics isotropic = optics;
  isotropic.layer.anisotropy = 0.0;
  const EpidermisTotals from = SolveEpidermisTotals(isotropic), to = SolveEpidermisTotals(optics);
  Scale(transforms.r_forward, from.r_forward, to.r_forward);
  Scale(transforms.t_forward, from.t_forward, to.t_forward);
  Scale(transforms.r_backward, from.r_backward, to.r_backward);
  Scale(transforms.t_backward, from.t_backward, to.t_backward);
  transforms.r_single.clear();  // of real events it is not known
}

void ApplyAnisotropy(const DermisOptics& optics, DermisTransforms& transforms) {
  DermisOptics isotropic = optics;
  isotropic.layer.anisotropy = 0.0;
  const DermisTotals from = SolveDermisTotals(isotropic), to = SolveDermisTotals(optics);
  Scale(transforms.r_diffuse, from.r_diffuse, to.r_diffuse);
  Scale(transforms.r_normal, from.r_normal, to.r_normal);
}

}  // namespace dermap
