// SPDX-License-Identifier: Apache-2.0
// Symmetric eigenproblem of the layer, and adding of flux matrices.
#include "common/optics/discrete_ordinates.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/optics/fresnel.h"

namespace dermap {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastEigenvalue = 1e-10;  // squared; of a layer that absorbs nothing it would be 0

// Phase function averaged over azimuth, as Legendre polynomials, into the same hemisphere and into the other.
struct PhaseMatrices {
  MatrixXd same, other;
  double forward_peak;  // share of scattering that is left out as forward
};
PhaseMatrices HenyeyGreenstein(const VectorXd& mu, const VectorXd& weight, double g) {
  const auto n = mu.size();
  const int terms = g == 0.0 ? 1 : static_cast<int>(n);
  PhaseMatrices phase{MatrixXd::Zero(n, n), MatrixXd::Zero(n, n), g == 0.0 ? 0.0 : std::pow(g, terms)};
  VectorXd before = VectorXd::Zero(n), legendre = VectorXd::Ones(n);
  double moment = 1.0;
  for (int l = 0; l < terms; ++l) {
    const double coefficient = (2 * l + 1) * (moment - phase.forward_peak) / (1.0 - phase.forward_peak);
    const MatrixXd term = coefficient * legendre * legendre.transpose();
    phase.same += term;
    phase.other += l % 2 == 0 ? term : (-term).eval();
    const VectorXd next = ((2 * l + 1) * mu.cwiseProduct(legendre) - l * before) / (l + 1.0);
    before = legendre;
    legendre = next;
    moment *= g;
  }
  // The quadrature misses the norm by a little; what is missing goes straight on, so that no light is lost.
  const VectorXd norm = 0.5 * (phase.same + phase.other) * weight;
  phase.same.diagonal() += (2.0 * (VectorXd::Ones(n) - norm)).cwiseQuotient(weight);
  return phase;
}

// x of x m = b.
MatrixXd DivideRight(const MatrixXd& b, const MatrixXd& m) {
  return m.transpose().partialPivLu().solve(b.transpose()).transpose();
}

}  // namespace

LightOperators SolvePlaneLayer(const AngularGrid& grid, int medium, const PlaneLayer& layer) {
  const VectorXd &mu = grid.mu[medium], &weight = grid.weight[medium];
  const PhaseMatrices phase = HenyeyGreenstein(mu, weight, layer.anisotropy);
  const double mu_s = layer.mu_s * (1.0 - phase.forward_peak), mu_t = layer.mu_a + mu_s;
  const double albedo = mu_s / mu_t;
  // With J = sqrt(w mu) I in each hemisphere, s = J+ + J- and d = J+ - J- obey s' = -P d and d' = -M s, P and
  // M symmetric: s'' = P M s.
  const VectorXd root_weight = weight.cwiseSqrt(), inverse_root_mu = mu.cwiseSqrt().cwiseInverse();
  const auto operate = [&](const MatrixXd& scattered) -> MatrixXd {
    const MatrixXd symmetric = root_weight.asDiagonal() * scattered * root_weight.asDiagonal();
    MatrixXd m = -0.5 * albedo * symmetric;
    m.diagonal().array() += 1.0;
    return inverse_root_mu.asDiagonal() * m * inverse_root_mu.asDiagonal();
  };
  const MatrixXd sums = operate(phase.same - phase.other), differences = operate(phase.same + phase.other);
  const MatrixXd lower = sums.llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(lower.transpose() * differences * lower);
  const VectorXd rates = eigen.eigenvalues().cwiseMax(kLeastEigenvalue).cwiseSqrt();  // per optical depth
  const MatrixXd s = lower * eigen.eigenvectors();
  const MatrixXd d =
      lower.transpose().triangularView<Eigen::Upper>().solve(eigen.eigenvectors() * rates.asDiagonal());
  const MatrixXd along = 0.5 * (s + d), against = 0.5 * (s - d);  // J+ and J- of modes that fall downwards

  MatrixXd r, t = MatrixXd::Zero(mu.size(), mu.size());
  if (std::isinf(layer.thickness_mm)) {
    r = DivideRight(against, along);
  } else {
    const VectorXd fall = (-layer.thickness_mm * mu_t * rates).array().exp();
    const MatrixXd even =
        DivideRight(against + along * fall.asDiagonal(), along + against * fall.asDiagonal());  // r + t
    const MatrixXd odd =
        DivideRight(against - along * fall.asDiagonal(), along - against * fall.asDiagonal());  // r - t
    r = 0.5 * (even + odd);
    t = 0.5 * (even - odd);
  }
  const VectorXd root_flux = weight.cwiseProduct(mu).cwiseSqrt();
  const auto fluxes = [&](const MatrixXd& m) -> MatrixXd {
    return root_flux.asDiagonal() * m * root_flux.cwiseInverse().asDiagonal();
  };
  const MatrixXd reflected = fluxes(r), transmitted = fluxes(t);
  return {reflected, transmitted, reflected, transmitted};
}

LightOperators SolveFace(const AngularGrid& grid, int above, int below, double absorbance) {
  const int upper = grid.Size(above), lower = grid.Size(below);
  LightOperators face{MatrixXd::Identity(upper, upper), MatrixXd::Zero(lower, upper),
                      MatrixXd::Identity(lower, lower), MatrixXd::Zero(upper, lower)};
  for (int i = 0; i < std::min(upper, lower); ++i) {
    const double f = FresnelReflectance(grid.mu[above](i), grid.n[above], grid.n[below]);
    face.r_down(i, i) = face.r_up(i, i) = f;
    face.t_down(i, i) = face.t_up(i, i) = (1.0 - f) * std::exp(-absorbance);
  }
  return face;
}

LightOperators Add(const LightOperators& above, const LightOperators& below) {
  const auto n = above.r_up.rows();
  const MatrixXd identity = MatrixXd::Identity(n, n);
  const MatrixXd down = (identity - above.r_up * below.r_down).partialPivLu().solve(above.t_down);
  const MatrixXd up = (identity - below.r_down * above.r_up).partialPivLu().solve(below.t_up);
  return {.r_down = above.r_down + above.t_up * (below.r_down * down),
          .t_down = below.t_down * down,
          .r_up = below.r_up + below.t_down * (above.r_up * up),
          .t_up = above.t_up * up};
}

}  // namespace dermap
