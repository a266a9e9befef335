// SPDX-License-Identifier: Apache-2.0
// Galerkin's method for the integral equation of one layer: kernel, driving terms, and what leaves.
#include "common/optics/exact_layer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

#include "common/core/kernel.h"
#include "common/optics/exact_mesh.h"
#include "common/optics/fresnel.h"
#include "common/optics/gauss_legendre.h"

namespace dermap {
namespace {

using Complex = std::complex<double>;

constexpr double kNoReflection = 1e-4;  // of a face, left out of the kernel (not of what leaves)
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The kernel without faces. Over the pseudo-angle psi, sin(psi) = kappa * nu, it is a sum of real
// exponentials at every kappa: K_0(x) = 1/2 int_0^{atan kappa} dpsi / sin(psi) exp(-kappa x / sin(psi)).
struct RealExponentials {
  std::vector<double> rates, weights;
};
RealExponentials FreeKernel(double kappa, int nodes) {
  static thread_local QuadratureRule rule;
  if (static_cast<int>(rule.nodes.size()) != nodes) rule = GaussLegendreRule(nodes, 0.0, 1.0);
  const double widest = std::atan(kappa);
  RealExponentials kernel;
  for (int m = 0; m < nodes; ++m) {
    const double nu = kappa < 1e-6 ? rule.nodes[m] : std::sin(rule.nodes[m] * widest) / kappa;
    const double span = kappa < 1e-6 ? 1.0 : widest / kappa;
    kernel.rates.push_back(1.0 / nu);
    kernel.weights.push_back(0.5 * rule.weights[m] * span / nu);
  }
  return kernel;
}

// sum[i][j] += sum over c of left[c][i] * right[c][j], c a multiple of 4.
DERMAP_KERNEL void AddProducts(const double* left, const double* right, int columns, int size, double* sum) {
  for (int c = 0; c < columns; c += 4) {
    const double *l = left + static_cast<std::ptrdiff_t>(c) * size,
                 *r = right + static_cast<std::ptrdiff_t>(c) * size;
    for (int i = 0; i < size; ++i) {
      const double a = l[i], b = l[size + i], d = l[2 * size + i], e = l[3 * size + i];
      double* row = sum + static_cast<std::ptrdiff_t>(i) * size;
      for (int j = 0; j < size; ++j) {
        row[j] += a * r[j] + b * r[size + j] + d * r[2 * size + j] + e * r[3 * size + j];
      }
    }
  }
}

// Radiance of diffuse light over direction.
double Brightness(double mu, double tilt) {
  return 1.0 + tilt * mu;
}

// Plain, without the standard's care for infinities.
inline Complex Product(const Complex& a, const Complex& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// int_0^1 exp(-z t) dt.
Complex UnitIntegral(Complex z) {
  if (std::abs(z) < 1e-3) return 1.0 - 0.5 * z * (1.0 - z / 3.0);
  return (1.0 - std::exp(-z)) / z;
}

class Galerkin {
 public:
  Galerkin(const ExactFaces& faces, double thickness, double albedo, double kappa,
           const ExactResolution& resolution);
  ExactResponses Solve();

 private:
  const ExactFaces& faces_;
  double albedo_, kappa_;
  const ExactResolution& resolution_;
  DepthMesh mesh_;
  double tau_;
  RowMatrix kernel_;
  // Share of a source's light that leaves unscattered, as a function of depth; phi_0 of diffuse light that
  // enters.
  Eigen::VectorXd leave_top_, leave_bottom_, enter_top_, enter_bottom_;
  std::vector<double> left_, right_;  // columns of the faces' part of the kernel
  // What is known in closed form for each direction: light along the normal that leaves after exactly one
  // scattering (over albedo), and diffuse light that crosses the layer or comes back without any.
  double single_back_ = 0.0, single_through_ = 0.0;
  double straight_down_ = 0.0, straight_up_ = 0.0, mirrored_down_ = 0.0, mirrored_up_ = 0.0;

  void AddFreeKernel();
  void AddFaces();
  void AddDirection(const ExactFaces::Direction& direction, double cos_azimuth, double share);
  Complex ProjectExponentials(Complex q, std::vector<Complex>& u, std::vector<Complex>& v) const;
  void AddColumns(const std::vector<Complex>& outer, Complex factor, const std::vector<Complex>& inner,
                  Complex other_factor, const std::vector<Complex>& other);
  Eigen::VectorXd NormalLight() const;
  void AddClosedForms();
  bool IsSlab() const { return !faces_.half_space; }
};

// Of a quarter turn; light without lateral structure needs one.
int AzimuthCount(double kappa, double per_kappa) {
  return kappa < 1e-6 ? 1 : 2 + static_cast<int>(per_kappa * kappa);
}

// How fast light dies away with optical depth far from the faces, by diffusion, but never faster than
// unscattered light.
double DecayRate(double albedo, double kappa) {
  return std::min(std::sqrt(1.0 + kappa * kappa), std::sqrt(3.0 * (1.0 - albedo) + kappa * kappa));
}

Galerkin::Galerkin(const ExactFaces& faces, double thickness, double albedo, double kappa,
                   const ExactResolution& resolution)
    : faces_(faces), albedo_(albedo), kappa_(kappa), resolution_(resolution) {
  const double decay = std::max(DecayRate(albedo, kappa), 1e-4);
  // A half-space ends, to the solver, where all but exp(-14) of what could still come back is lost.
  tau_ = IsSlab() ? thickness : std::max(7.0 / decay, 12.0 / (1.0 + kappa));
  const MeshGrading grading{resolution.smallest_element / (1.0 + 0.5 * std::min(kappa, 20.0)),
                            resolution.element_ratio,
                            IsSlab() ? std::max(resolution.largest_element / decay, tau_ / 12.0) : tau_};
  mesh_ = MakeDepthMesh(tau_, grading, IsSlab());
  kernel_ = RowMatrix::Zero(mesh_.Size(), mesh_.Size());
  leave_top_ = leave_bottom_ = enter_top_ = enter_bottom_ = Eigen::VectorXd::Zero(mesh_.Size());
}

void Galerkin::AddFreeKernel() {
  const RealExponentials free = FreeKernel(kappa_, resolution_.free_nodes);
  const int elements = mesh_.ElementCount(), nodes = static_cast<int>(free.rates.size());
  std::vector<ExponentialMoments<double>> moments(static_cast<std::size_t>(elements) * nodes);
  for (int e = 0; e < elements; ++e) {
    for (int m = 0; m < nodes; ++m)
      moments[e * nodes + m] = MomentsOfExponential(free.rates[m], mesh_.Height(e));
  }
  using Block = Eigen::Matrix<double, kElementModes, kElementModes, Eigen::RowMajor>;
  std::vector<double> gap(nodes);
  for (int a = 0; a < elements; ++a) {
    auto own = kernel_.block<kElementModes, kElementModes>(a * kElementModes, a * kElementModes);
    for (int m = 0; m < nodes; ++m) {
      const SelfMoments self =
          SelfMomentsOfExponential(free.rates[m], mesh_.Height(a), moments[a * nodes + m]);
      own += free.weights[m] * Eigen::Map<const Block>(self.data());
    }
    std::copy(free.weights.begin(), free.weights.end(),
              gap.begin());  // times exp(-rate * gap between elements)
    for (int b = a + 1; b < elements; ++b) {
      Block pair = Block::Zero();
      for (int m = 0; m < nodes; ++m) {
        const auto& above =
            moments[a * nodes + m].values;  // from the element's lower end: odd ones change sign
        const auto& below = moments[b * nodes + m].values;
        const Eigen::Map<const Eigen::Vector4d> lower(below.data());
        pair += Eigen::Vector4d(above[0], -above[1], above[2], -above[3]) * (gap[m] * lower).transpose();
        gap[m] *= moments[b * nodes + m].fall;
      }
      kernel_.block<kElementModes, kElementModes>(a * kElementModes, b * kElementModes) = pair;
      kernel_.block<kElementModes, kElementModes>(b * kElementModes, a * kElementModes) = pair.transpose();
    }
  }
}

// Re[outer inner'] as real columns: a a' - b b' for a complex a + ib, and so on.
void Galerkin::AddColumns(const std::vector<Complex>& outer, Complex factor,
                          const std::vector<Complex>& inner, Complex other_factor,
                          const std::vector<Complex>& other) {
  const std::size_t size = outer.size(), start = left_.size();
  left_.resize(start + 2 * size);
  right_.resize(start + 2 * size);
  for (std::size_t i = 0; i < size; ++i) {
    const Complex x = Product(factor, inner[i]) + Product(other_factor, other[i]);
    left_[start + i] = outer[i].real();
    left_[start + size + i] = -outer[i].imag();
    right_[start + i] = x.real();
    right_[start + size + i] = x.imag();
  }
}

// exp(-q x) and exp(-q (tau - x)) in the basis; returns exp(-q tau).
Complex Galerkin::ProjectExponentials(Complex q, std::vector<Complex>& u, std::vector<Complex>& v) const {
  const int elements = mesh_.ElementCount();
  const int distinct = IsSlab() ? (elements + 1) / 2 : elements;  // the mesh of a slab is symmetric
  static thread_local std::vector<ExponentialMoments<Complex>> moments;
  moments.clear();
  for (int e = 0; e < distinct; ++e) moments.push_back(MomentsOfExponential(q, mesh_.Height(e)));
  u.resize(mesh_.Size());
  v.assign(mesh_.Size(), Complex(0.0));
  Complex depth = 1.0;  // exp(-q x) at the element's upper end
  for (int e = 0; e < elements; ++e) {
    const auto& m = moments[std::min(e, IsSlab() ? elements - 1 - e : e)];
    for (int i = 0; i < kElementModes; ++i) u[e * kElementModes + i] = Product(depth, m.values[i]);
    depth = Product(depth, m.fall);
  }
  if (!IsSlab()) return depth;
  for (int e = 0; e < elements; ++e) {
    for (int i = 0; i < kElementModes; ++i) {
      v[e * kElementModes + i] = (i % 2 == 0 ? 1.0 : -1.0) * u[(elements - 1 - e) * kElementModes + i];
    }
  }
  return depth;
}

// Everything that light in one direction (and its mirror image) adds; share: the direction's weight in
// azimuth.
void Galerkin::AddDirection(const ExactFaces::Direction& d, double cos_azimuth, double share) {
  const Complex q = Complex(1.0, kappa_ * std::sqrt(1.0 - d.mu * d.mu) * cos_azimuth) / d.mu;
  static thread_local std::vector<Complex> u, v;
  const Complex across = ProjectExponentials(q, u, v);
  const Complex bounces = 1.0 / (1.0 - d.top * d.bottom * across * across);
  const double weight = share * d.weight;
  // Images: Re[top u u' + bottom v v' + both (u v' + v u')]. What a face hardly reflects is left out.
  const Complex kernel = 0.5 * weight / d.mu * bounces;
  const Complex top = kernel * d.top, bottom = kernel * d.bottom, both = top * d.bottom * across;
  if (d.top > kNoReflection) AddColumns(u, top, u, d.bottom > kNoReflection ? both : 0.0, v);
  if (d.bottom > kNoReflection) AddColumns(v, bottom, v, d.top > kNoReflection ? both : 0.0, u);

  const Complex leave = 0.5 * weight * bounces;
  const double enter_top = 2.0 * Brightness(d.mu, faces_.tilt_down) / faces_.open_top;
  const double enter_bottom = 2.0 * Brightness(d.mu, faces_.tilt_up) / faces_.open_bottom;
  const Complex by_bottom = leave * d.bottom * across, by_top = leave * d.top * across;
  for (int i = 0; i < mesh_.Size(); ++i) {
    const double up = (1.0 - d.top) * (Product(leave, u[i]) + Product(by_bottom, v[i])).real();
    const double down = (1.0 - d.bottom) * (Product(leave, v[i]) + Product(by_top, u[i])).real();
    leave_top_(i) += up;
    leave_bottom_(i) += down;
    enter_top_(i) += enter_top * up;
    enter_bottom_(i) += enter_bottom * down;
  }
}

void Galerkin::AddFaces() {
  const int azimuths =
      std::min(AzimuthCount(kappa_, resolution_.azimuths_per_kappa), resolution_.max_azimuths);
  left_.clear();
  right_.clear();
  for (const ExactFaces::Direction& direction : faces_.directions) {
    for (int j = 0; j < azimuths; ++j) {
      const double azimuth = 0.5 * std::numbers::pi * (j + 0.5) / azimuths;
      AddDirection(direction, std::cos(azimuth), 1.0 / azimuths);
    }
  }
  const int size = mesh_.Size();
  int columns = static_cast<int>(left_.size()) / size;
  for (; columns % 4 != 0; ++columns) {
    left_.resize(left_.size() + size, 0.0);
    right_.resize(right_.size() + size, 0.0);
  }
  AddProducts(left_.data(), right_.data(), columns, size, kernel_.data());
}

// phi_0 of light along the normal, with its own bounces between the faces.
Eigen::VectorXd Galerkin::NormalLight() const {
  Eigen::VectorXd light(mesh_.Size());
  const double across = IsSlab() ? std::exp(-tau_) : 0.0;
  const double bounces = 1.0 / (1.0 - faces_.normal_top * faces_.normal_bottom * across * across);
  const int elements = mesh_.ElementCount();
  double depth = bounces;
  for (int e = 0; e < elements; ++e) {
    const auto moments = MomentsOfExponential(1.0, mesh_.Height(e));
    for (int i = 0; i < kElementModes; ++i) light(e * kElementModes + i) = depth * moments.values[i];
    depth *= moments.fall;
  }
  if (!IsSlab()) return light;
  Eigen::VectorXd mirrored(mesh_.Size());
  for (int e = 0; e < elements; ++e) {
    for (int i = 0; i < kElementModes; ++i) {
      mirrored(e * kElementModes + i) =
          (i % 2 == 0 ? 1.0 : -1.0) * light((elements - 1 - e) * kElementModes + i);
    }
  }
  return light + faces_.normal_bottom * across * mirrored;
}

// These are narrower in depth than the elements where kappa is large, and need more azimuths.
void Galerkin::AddClosedForms() {
  const int azimuths = AzimuthCount(kappa_, 2.0 * resolution_.azimuths_per_kappa);
  const double normal = IsSlab() ? std::exp(-tau_) : 0.0;
  const double first = 1.0 / (1.0 - faces_.normal_top * faces_.normal_bottom * normal * normal);
  const double second = first * faces_.normal_bottom * normal;  // coming back up
  for (const ExactFaces::Direction& d : faces_.directions) {
    for (int j = 0; j < azimuths; ++j) {
      const double cos_azimuth = std::cos(0.5 * std::numbers::pi * (j + 0.5) / azimuths);
      const Complex q = Complex(1.0, kappa_ * std::sqrt(1.0 - d.mu * d.mu) * cos_azimuth) / d.mu;
      const double weight = d.weight / azimuths;
      if (!IsSlab()) {
        single_back_ += 0.5 * weight * (1.0 - d.top) * (1.0 / (1.0 + q)).real();
        continue;
      }
      const Complex across = std::exp(-q * tau_);
      const Complex with = tau_ * UnitIntegral((1.0 + q) * tau_);  // int exp(-x) exp(-q x) dx
      const Complex against =
          tau_ * normal * UnitIntegral((q - 1.0) * tau_);  // int exp(-x) exp(-q (tau - x)) dx
      const Complex upward = first * with + second * against, downward = first * against + second * with;
      const Complex bounces = weight / (1.0 - d.top * d.bottom * across * across);
      single_back_ += 0.5 * (1.0 - d.top) * (bounces * (upward + d.bottom * across * downward)).real();
      single_through_ += 0.5 * (1.0 - d.bottom) * (bounces * (downward + d.top * across * upward)).real();
      const Complex straight = d.mu * bounces * across;
      const double down = (1.0 - d.top) * Brightness(d.mu, faces_.tilt_down) / faces_.open_top;
      const double up = (1.0 - d.bottom) * Brightness(d.mu, faces_.tilt_up) / faces_.open_bottom;
      straight_down_ += down * (1.0 - d.bottom) * straight.real();
      straight_up_ += up * (1.0 - d.top) * straight.real();
      mirrored_down_ += down * (1.0 - d.top) * d.bottom * (straight * across).real();
      mirrored_up_ += up * (1.0 - d.bottom) * d.top * (straight * across).real();
    }
  }
}

ExactResponses Galerkin::Solve() {
  AddFreeKernel();
  AddFaces();
  const int size = mesh_.Size();
  const Eigen::MatrixXd system = Eigen::MatrixXd::Identity(size, size) - albedo_ * kernel_;
  const Eigen::LDLT<Eigen::MatrixXd> solver(system);
  // By symmetry of the kernel one solution for each way out serves every way in.
  const Eigen::VectorXd top = solver.solve(leave_top_), bottom = solver.solve(leave_bottom_);
  const Eigen::VectorXd normal = NormalLight();
  AddClosedForms();

  ExactResponses r;
  r.r_normal_single = albedo_ * single_back_;
  r.r_normal = albedo_ * (single_back_ + (top - leave_top_).dot(normal));
  r.r_down = albedo_ * top.dot(enter_top_) + mirrored_down_;
  if (!IsSlab()) return r;
  r.t_normal = albedo_ * (single_through_ + (bottom - leave_bottom_).dot(normal));
  const double across = std::exp(-tau_);
  const double bounces = 1.0 / (1.0 - faces_.normal_top * faces_.normal_bottom * across * across);
  r.t_ballistic = (1.0 - faces_.normal_bottom) * across * bounces;
  r.r_ballistic = (1.0 - faces_.normal_top) * faces_.normal_bottom * across * across * bounces;
  r.t_down = albedo_ * bottom.dot(enter_top_) + straight_down_;
  r.r_up = albedo_ * bottom.dot(enter_bottom_) + mirrored_up_;
  r.t_up = albedo_ * top.dot(enter_bottom_) + straight_up_;
  return r;
}

}  // namespace

ExactFaces MakeExactFaces(double n_above, double n, double n_below, bool black_above, bool half_space,
                          const ExactResolution& resolution) {
  // Angles are split where a face begins to reflect totally; between, the rule runs in the cosine of the
  // thinnest medium that still carries the light, in which Fresnel's formulas are smooth.
  std::vector<double> indices{n};
  if (n_above < n) indices.push_back(n_above);
  if (n_below < n && !half_space) indices.push_back(n_below);
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  ExactFaces faces;
  faces.half_space = half_space;
  double lower = 0.0;
  for (const double index : indices) {
    const double widest = std::sqrt(1.0 - lower * lower / (index * index));
    const QuadratureRule rule = GaussLegendreRule(resolution.nodes_per_interval, 0.0, widest);
    for (int i = 0; i < resolution.nodes_per_interval; ++i) {
      const double sine = index / n * std::sqrt(1.0 - rule.nodes[i] * rule.nodes[i]);  // Snell
      ExactFaces::Direction d{};
      d.mu = std::sqrt(1.0 - sine * sine);
      d.weight = rule.weights[i] * rule.nodes[i] * index * index / (n * n * d.mu);
      d.top = black_above ? 0.0 : FresnelReflectance(d.mu, n, n_above);
      d.bottom = half_space ? 0.0 : FresnelReflectance(d.mu, n, n_below);
      faces.open_top += d.weight * d.mu * (1.0 - d.top) * Brightness(d.mu, faces.tilt_down);
      faces.open_bottom += d.weight * d.mu * (1.0 - d.bottom) * Brightness(d.mu, faces.tilt_up);
      faces.directions.push_back(d);
    }
    lower = index;
  }
  faces.normal_top = black_above ? 0.0 : FresnelReflectance(1.0, n, n_above);
  faces.normal_bottom = half_space ? 0.0 : FresnelReflectance(1.0, n, n_below);
  return faces;
}

ExactResponses SolveExactLayer(const ExactFaces& faces, double thickness, double albedo, double kappa,
                               const ExactResolution& resolution) {
  assert(albedo >= 0.0 && albedo <= 1.0 && kappa >= 0.0);
  return Galerkin(faces, thickness, albedo, kappa, resolution).Solve();
}

}  // namespace dermap
