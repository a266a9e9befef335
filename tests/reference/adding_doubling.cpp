// SPDX-License-Identifier: Apache-2.0
// Adding-doubling on flux vectors: diagonal Fresnel faces, slabs doubled from a thin diamond start.
#include "tests/reference/adding_doubling.h"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "tests/reference/quadrature.h"

namespace dermap::reference {
namespace {

constexpr double kStartThickness = 1e-5;  // optical, at most; the start's error is of second order in it
constexpr int kMaxDoublings = 60;

double FresnelReflectance(double n_in, double n_out, double mu_in) {
  const double sine = n_in / n_out * std::sqrt(std::max(0.0, 1.0 - mu_in * mu_in));
  if (sine >= 1.0) return 1.0;
  const double mu_out = std::sqrt(1.0 - sine * sine);
  const double s = (n_in * mu_in - n_out * mu_out) / (n_in * mu_in + n_out * mu_out);
  const double p = (n_in * mu_out - n_out * mu_in) / (n_in * mu_out + n_out * mu_in);
  return 0.5 * (s * s + p * p);
}

// Mean over azimuth of the Henyey-Greenstein phase function, normalised so that 1/2 int over all mu is 1, as
// a sum of Legendre polynomials; `sign` is +1 into the same hemisphere and -1 into the other.
Eigen::MatrixXd Redistribution(const std::vector<double>& mu, const std::vector<double>& weight, double g,
                               double sign) {
  const int n = static_cast<int>(mu.size());
  const int terms = g == 0.0 ? 1 : std::min(2 * n, 400);
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd before = Eigen::VectorXd::Zero(n), legendre = Eigen::VectorXd::Ones(n);
  const Eigen::VectorXd cosines = Eigen::Map<const Eigen::VectorXd>(mu.data(), n);
  double coefficient = 1.0;
  for (int l = 0; l < terms; ++l) {
    p += (2 * l + 1) * coefficient * legendre * legendre.transpose();
    const Eigen::VectorXd next =
        ((2 * l + 1) * cosines.cwiseProduct(legendre) - l * before) / static_cast<double>(l + 1);
    before = legendre;
    legendre = next;
    coefficient *= g * sign;
  }
  const Eigen::VectorXd w = Eigen::Map<const Eigen::VectorXd>(weight.data(), n);
  return 0.5 * w.asDiagonal() * p;  // share scattered into node i from node j
}

}  // namespace

AngularNodes MakeAngularNodes(const std::vector<double>& n, int nodes_per_interval) {
  std::vector<double> distinct = n;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  // Nodes in each interval of n sin(theta), in the cosine of the thinnest medium that still carries it.
  std::vector<double> invariant, flux_weight;  // flux_weight: n^2 mu d mu, the same in every medium
  double lower = 0.0;
  for (const double upper : distinct) {
    const double mu_max = std::sqrt(std::max(0.0, 1.0 - lower * lower / (upper * upper)));
    const Rule rule = lower == 0.0 ? GaussRadauRight(nodes_per_interval, 0.0, 1.0)
                                   : GaussLegendre(nodes_per_interval, 0.0, mu_max);
    for (int i = nodes_per_interval - 1; i >= 0; --i) {
      const double mu = rule.nodes[i];
      invariant.push_back(upper * std::sqrt(std::max(0.0, 1.0 - mu * mu)));
      flux_weight.push_back(upper * upper * mu * rule.weights[i]);
    }
    lower = upper;
  }
  AngularNodes nodes;
  nodes.n = n;
  for (const double index : n) {
    std::vector<double> mu, weight;
    for (std::size_t i = 0; i < invariant.size() && invariant[i] < index; ++i) {
      mu.push_back(std::sqrt(1.0 - invariant[i] * invariant[i] / (index * index)));
      weight.push_back(flux_weight[i] / (index * index * mu.back()));
    }
    nodes.count.push_back(static_cast<int>(mu.size()));
    nodes.mu.push_back(mu);
    nodes.weight.push_back(weight);
  }
  return nodes;
}

Operators Add(const Operators& above, const Operators& below) {
  const Eigen::Index n = above.r_up.rows();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  const Eigen::PartialPivLU<Eigen::MatrixXd> between_down(identity - above.r_up * below.r_down);
  const Eigen::PartialPivLU<Eigen::MatrixXd> between_up(identity - below.r_down * above.r_up);
  const Eigen::MatrixXd down = between_down.solve(above.t_down);  // flux going down between the two
  const Eigen::MatrixXd up = between_up.solve(below.t_up);
  Operators sum;
  sum.t_down = below.t_down * down;
  sum.r_down = above.r_down + above.t_up * (below.r_down * down);
  sum.t_up = above.t_up * up;
  sum.r_up = below.r_up + below.t_down * (above.r_up * up);
  return sum;
}

AddingDoubling::AddingDoubling(const LayerStack& stack, int nodes_per_interval) : stack_(stack) {
  std::vector<double> n{stack.n_above};
  for (const Layer& layer : stack.layers) n.push_back(layer.n);
  n.push_back(stack.n_below);
  nodes_ = MakeAngularNodes(n, nodes_per_interval);
}

double AddingDoubling::IndexOf(int medium) const {
  return nodes_.n[medium];
}

Operators AddingDoubling::Face(int upper, int lower, double absorbance) const {
  const int above = nodes_.count[upper], below = nodes_.count[lower];
  const double pass = std::exp(-absorbance);
  Operators face;
  face.r_down = Eigen::MatrixXd::Identity(above, above);
  face.r_up = Eigen::MatrixXd::Identity(below, below);
  face.t_down = Eigen::MatrixXd::Zero(below, above);
  face.t_up = Eigen::MatrixXd::Zero(above, below);
  for (int i = 0; i < std::min(above, below); ++i) {
    const double f = FresnelReflectance(IndexOf(upper), IndexOf(lower), nodes_.mu[upper][i]);
    face.r_down(i, i) = face.r_up(i, i) = f;
    face.t_down(i, i) = face.t_up(i, i) = (1.0 - f) * pass;
  }
  return face;
}

Operators AddingDoubling::Slab(int layer) const {
  const Layer& l = stack_.layers[layer];
  const int medium = layer + 1, n = nodes_.count[medium];
  const double mu_t = l.mu_a + l.mu_s, albedo = mu_t > 0.0 ? l.mu_s / mu_t : 0.0;
  const bool infinite = std::isinf(l.thickness_mm);
  const double tau = infinite ? kStartThickness : l.thickness_mm * mu_t;
  const int doublings =
      infinite ? kMaxDoublings : std::max(0, static_cast<int>(std::ceil(std::log2(tau / kStartThickness))));
  const double start = std::ldexp(tau, infinite ? 0 : -doublings);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd inverse_mu =
      Eigen::Map<const Eigen::VectorXd>(nodes_.mu[medium].data(), n).cwiseInverse();
  Eigen::MatrixXd same = Redistribution(nodes_.mu[medium], nodes_.weight[medium], l.g, 1.0);
  Eigen::MatrixXd other = Redistribution(nodes_.mu[medium], nodes_.weight[medium], l.g, -1.0);
  // The quadrature of a peaked phase function misses its norm by a little; no light may be lost by that.
  const Eigen::RowVectorXd norm = (same.colwise().sum() + other.colwise().sum()).cwiseInverse();
  same = (same * norm.asDiagonal()).eval();
  other = (other * norm.asDiagonal()).eval();
  // Each flux loses (or scatters) its share over half of the thin slab: the diamond scheme.
  const Eigen::MatrixXd loss = 0.5 * start * (identity - albedo * same) * inverse_mu.asDiagonal();
  const Eigen::MatrixXd back = 0.5 * start * albedo * other * inverse_mu.asDiagonal();
  const Eigen::PartialPivLU<Eigen::MatrixXd> implicit(identity + loss);
  const Eigen::MatrixXd step = implicit.solve(identity - loss), turn = implicit.solve(back);
  const Eigen::MatrixXd turn_twice = turn * turn;
  Eigen::MatrixXd t = (identity - turn_twice).partialPivLu().solve(step + turn_twice);
  Eigen::MatrixXd r = turn * (identity + t);
  for (int i = 0; i < doublings; ++i) {
    const Eigen::MatrixXd down = (identity - r * r).partialPivLu().solve(t);
    r = (r + t * (r * down)).eval();
    t = (t * down).eval();
    if (infinite && t.cwiseAbs().maxCoeff() < 1e-15) break;
  }
  return {r, t, r, t};
}

Operators AddingDoubling::Part(int first, int last, bool include_first, bool include_last) const {
  const int layer_count = static_cast<int>(stack_.layers.size());
  assert(0 <= first && first <= last && last <= layer_count + 1);
  Operators whole;
  bool empty = true;
  const auto append = [&](const Operators& part) {
    whole = empty ? part : Add(whole, part);
    empty = false;
  };
  for (int medium = first; medium <= last; ++medium) {
    const bool is_layer = medium >= 1 && medium <= layer_count;
    const bool wanted = (medium != first || include_first) && (medium != last || include_last);
    if (medium > first)
      append(Face(medium - 1, medium, medium >= 2 ? stack_.layers[medium - 2].absorber_below : 0.0));
    if (is_layer && wanted) append(Slab(medium - 1));
  }
  return whole;
}

Eigen::VectorXd AddingDoubling::LambertianFlux(int medium, int through, bool transmitted) const {
  Eigen::VectorXd flux = Eigen::VectorXd::Zero(nodes_.count[medium]);
  for (int i = 0; i < std::min(nodes_.count[medium], nodes_.count[through]); ++i) {
    const double mu = nodes_.mu[medium][i];
    const double pass = transmitted ? 1.0 - FresnelReflectance(nodes_.n[medium], nodes_.n[through], mu) : 1.0;
    flux(i) = mu * nodes_.weight[medium][i] * pass;
  }
  return flux / flux.sum();
}

Totals AddingDoubling::NormalIncidence() const {
  const Operators whole = Whole();
  Totals totals;
  totals.specular = FresnelReflectance(nodes_.n[0], nodes_.n[1], 1.0);
  totals.reflectance = whole.r_down.col(nodes_.normal).sum() - totals.specular;
  totals.transmittance = whole.t_down.col(nodes_.normal).sum();
  totals.ballistic = 1.0 - totals.specular;
  for (std::size_t i = 0; i < stack_.layers.size(); ++i) {
    const Layer& l = stack_.layers[i];
    totals.ballistic *= std::exp(-l.thickness_mm * (l.mu_a + l.mu_s) - l.absorber_below) *
                        (1.0 - FresnelReflectance(nodes_.n[i + 1], nodes_.n[i + 2], 1.0));
  }
  return totals;
}

Totals NormalIncidenceTotals(const LayerStack& stack, int nodes_per_interval) {
  return AddingDoubling(stack, nodes_per_interval).NormalIncidence();
}

}  // namespace dermap::reference
