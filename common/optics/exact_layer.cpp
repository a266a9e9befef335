// SPDX-License-Identifier: Apache-2.0
// Galerkin's method for the integral equation of one layer: kernel, driving terms, and what leaves.
#include "common/optics/exact_layer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "common/optics/exact_kernel.h"
#include "common/optics/exact_mesh.h"

namespace dermap {
namespace {

using Complex = std::complex<double>;

constexpr double kNoReflection = 1e-4;  // of a face: left out of the kernel (not of what leaves)

// Of a quarter turn; light without lateral structure needs one.
int AzimuthCount(double kappa, double per_kappa) {
  return kappa < 1e-6 ? 1 : 2 + static_cast<int>(per_kappa * kappa);
}
double CosineOfAzimuth(int index, int count) {
  return std::cos(0.5 * std::numbers::pi * (index + 0.5) / count);
}

// int_0^1 exp(-z t) dt.
Complex UnitIntegral(Complex z) {
  if (std::abs(z) < 1e-3) return 1.0 - 0.5 * z * (1.0 - z / 3.0);
  return (1.0 - std::exp(-z)) / z;
}

// Mirrored in the middle of a symmetric mesh: x to tau - x.
template <class Vector>
void Mirror(const Vector& from, int elements, Vector& to) {
  for (int e = 0; e < elements; ++e) {
    for (int i = 0; i < kElementModes; ++i) {
      to[e * kElementModes + i] = (i % 2 == 0 ? 1.0 : -1.0) * from[(elements - 1 - e) * kElementModes + i];
    }
  }
}

class Galerkin {
 public:
  Galerkin(const ExactFaces& faces, const ExactLayer& layer, const ExactResolution& resolution);
  ExactResponses Solve();

 private:
  using Direction = ExactFaces::Direction;
  using Column = ColumnProducts::Column;
  const ExactFaces& faces_;
  const ExactLayer& layer_;
  const ExactResolution& resolution_;
  double tau_;
  DepthMesh mesh_;
  KernelMatrix kernel_;
  // Share of a source's light that leaves unscattered through a face, as a function of depth.
  Eigen::VectorXd leave_top_, leave_bottom_;
  // phi_0 of the neighbours' light, and its flux, which all shares of it are divided by.
  Eigen::VectorXd enter_top_, enter_bottom_;
  double flux_top_ = 0.0, flux_bottom_ = 0.0;
  // What is known in closed form for each direction: light along the normal that leaves after exactly one
  // scattering (over albedo), and diffuse light that crosses the layer or is mirrored back without any.
  double single_back_ = 0.0, single_through_ = 0.0;
  double straight_down_ = 0.0, straight_up_ = 0.0, mirrored_down_ = 0.0, mirrored_up_ = 0.0;

  bool IsSlab() const { return !faces_.half_space; }
  // The largest kappa that an integral over azimuth meets.
  double Lean() const {
    return std::max({layer_.kappa, SaturatedKappa(layer_.above, layer_.kappa),
                     SaturatedKappa(layer_.below, layer_.kappa)});
  }
  Complex Rate(const Direction& d, double cos_azimuth) const {
    return Complex(1.0, layer_.kappa * std::sqrt(1.0 - d.mu * d.mu) * cos_azimuth) / d.mu;
  }
  Complex ProjectExponentials(Complex q, Column& u, Column& v) const;
  void AddFaces();
  void AddDirection(const Direction& d, double cos_azimuth, double share, ColumnProducts& products);
  Eigen::VectorXd NormalLight() const;
  void AddClosedForms();
  void AddSingleScattering(const Direction& d, Complex q, double weight);
  void AddStraightLight(const Direction& d, Complex q, double cos_azimuth, double weight);
};

Galerkin::Galerkin(const ExactFaces& faces, const ExactLayer& layer, const ExactResolution& resolution)
    : faces_(faces), layer_(layer), resolution_(resolution) {
  const double kappa = layer.kappa, decay = std::max(DecayRate(layer.albedo, kappa), 1e-4);
  // A half-space ends, to the solver, where all but exp(-14) of what could still come back is lost.
  tau_ = IsSlab() ? layer.thickness : std::max(7.0 / decay, 12.0 / (1.0 + kappa));
  const double largest =
      IsSlab() ? std::max({resolution.largest_element / decay, tau_ / 12.0, resolution.least_largest_element})
               : tau_;
  const double smallest = resolution.smallest_element / (1.0 + 0.5 * std::min(kappa, 20.0));
  mesh_ = MakeDepthMesh(tau_, {smallest, resolution.element_ratio, largest}, IsSlab());
  kernel_ = KernelMatrix::Zero(mesh_.Size(), mesh_.Size());
  leave_top_ = leave_bottom_ = enter_top_ = enter_bottom_ = Eigen::VectorXd::Zero(mesh_.Size());
}

// u = exp(-q x) and v = exp(-q (tau - x)) in the basis (v = 0 for a half-space); returns exp(-q tau).
Complex Galerkin::ProjectExponentials(Complex q, Column& u, Column& v) const {
  const int elements = mesh_.ElementCount();
  const int distinct = IsSlab() ? (elements + 1) / 2 : elements;  // the mesh of a slab is symmetric
  static thread_local std::vector<ExponentialMoments<Complex>> moments;
  moments.clear();
  for (int e = 0; e < distinct; ++e) moments.push_back(MomentsOfExponential(q, mesh_.Height(e)));
  u.resize(mesh_.Size());
  v.assign(mesh_.Size(), Complex(0.0));
  Complex depth = 1.0;  // exp(-q x) at the element's upper end
  for (int e = 0; e < elements; ++e) {
    const auto& m = moments[IsSlab() ? std::min(e, elements - 1 - e) : e];
    for (int i = 0; i < kElementModes; ++i) u[e * kElementModes + i] = Product(depth, m.values[i]);
    depth = Product(depth, m.fall);
  }
  if (IsSlab()) Mirror(u, elements, v);
  return depth;
}

// Everything that light in one direction (and its mirror images in azimuth) adds; share: its weight in
// azimuth.
void Galerkin::AddDirection(const Direction& d, double cos_azimuth, double share, ColumnProducts& products) {
  const Complex q = Rate(d, cos_azimuth);
  static thread_local Column u, v;
  const Complex across = ProjectExponentials(q, u, v);
  const Complex bounces = 1.0 / (1.0 - d.top * d.bottom * across * across);
  const double weight = share * d.weight;
  // Images: Re[top u u' + bottom v v' + both (u v' + v u')]. What a face hardly reflects is left out.
  const Complex kernel = 0.5 * weight / d.mu * bounces;
  const Complex top = kernel * d.top, bottom = kernel * d.bottom, both = top * d.bottom * across;
  if (d.top > kNoReflection) products.Add(u, top, u, d.bottom > kNoReflection ? both : 0.0, v);
  if (d.bottom > kNoReflection) products.Add(v, bottom, v, d.top > kNoReflection ? both : 0.0, u);

  const Complex from_above = DiffuseRadiance(layer_.above, d.mu, cos_azimuth, layer_.kappa);
  const Complex from_below = DiffuseRadiance(layer_.below, d.mu, cos_azimuth, layer_.kappa);
  const Complex leave = 0.5 * weight * bounces;
  const Complex by_bottom = leave * d.bottom * across, by_top = leave * d.top * across;
  for (int i = 0; i < mesh_.Size(); ++i) {
    const Complex up = (1.0 - d.top) * (Product(leave, u[i]) + Product(by_bottom, v[i]));
    const Complex down = (1.0 - d.bottom) * (Product(leave, v[i]) + Product(by_top, u[i]));
    leave_top_(i) += up.real();
    leave_bottom_(i) += down.real();
    enter_top_(i) += 2.0 * Product(from_above, up).real();
    enter_bottom_(i) += 2.0 * Product(from_below, down).real();
  }
}

void Galerkin::AddFaces() {
  const int azimuths =
      std::min(AzimuthCount(Lean(), resolution_.azimuths_per_kappa), resolution_.max_azimuths);
  ColumnProducts products(mesh_.Size());
  for (const Direction& direction : faces_.directions) {
    for (int j = 0; j < azimuths; ++j) {
      AddDirection(direction, CosineOfAzimuth(j, azimuths), 1.0 / azimuths, products);
    }
  }
  products.AddTo(kernel_);
}

// phi_0 of light along the normal, with its own bounces between the faces.
Eigen::VectorXd Galerkin::NormalLight() const {
  Eigen::VectorXd light(mesh_.Size());
  const double across = IsSlab() ? std::exp(-tau_) : 0.0;
  const int elements = mesh_.ElementCount();
  double depth = 1.0 / (1.0 - faces_.normal_top * faces_.normal_bottom * across * across);
  for (int e = 0; e < elements; ++e) {
    const auto moments = MomentsOfExponential(1.0, mesh_.Height(e));
    for (int i = 0; i < kElementModes; ++i) light(e * kElementModes + i) = depth * moments.values[i];
    depth *= moments.fall;
  }
  if (!IsSlab()) return light;
  Eigen::VectorXd mirrored(mesh_.Size());
  Mirror(light, elements, mirrored);
  return light + faces_.normal_bottom * across * mirrored;
}

void Galerkin::AddSingleScattering(const Direction& d, Complex q, double weight) {
  if (!IsSlab()) {
    single_back_ += 0.5 * weight * (1.0 - d.top) * (1.0 / (1.0 + q)).real();
    return;
  }
  const double normal = std::exp(-tau_);
  const double first = 1.0 / (1.0 - faces_.normal_top * faces_.normal_bottom * normal * normal);
  const double second = first * faces_.normal_bottom * normal;  // coming back up
  const Complex across = std::exp(-q * tau_);
  const Complex with = tau_ * UnitIntegral((1.0 + q) * tau_);              // int exp(-x) exp(-q x) dx
  const Complex against = tau_ * normal * UnitIntegral((q - 1.0) * tau_);  // int exp(-x) exp(-q (tau - x)) dx
  const Complex up = first * with + second * against, down = first * against + second * with;
  const Complex bounces = 0.5 * weight / (1.0 - d.top * d.bottom * across * across);
  single_back_ += (1.0 - d.top) * (bounces * (up + d.bottom * across * down)).real();
  single_through_ += (1.0 - d.bottom) * (bounces * (down + d.top * across * up)).real();
}

void Galerkin::AddStraightLight(const Direction& d, Complex q, double cos_azimuth, double weight) {
  const Complex down =
      weight * d.mu * (1.0 - d.top) * DiffuseRadiance(layer_.above, d.mu, cos_azimuth, layer_.kappa);
  flux_top_ += down.real();
  if (!IsSlab()) return;
  const Complex up =
      weight * d.mu * (1.0 - d.bottom) * DiffuseRadiance(layer_.below, d.mu, cos_azimuth, layer_.kappa);
  flux_bottom_ += up.real();
  const Complex across = std::exp(-q * tau_);
  const Complex straight = across / (1.0 - d.top * d.bottom * across * across);
  straight_down_ += (1.0 - d.bottom) * (down * straight).real();
  straight_up_ += (1.0 - d.top) * (up * straight).real();
  mirrored_down_ += (1.0 - d.top) * d.bottom * (down * straight * across).real();
  mirrored_up_ += (1.0 - d.bottom) * d.top * (up * straight * across).real();
}

// Narrower in depth than the elements where kappa is large, these need more directions than the kernel.
void Galerkin::AddClosedForms() {
  const int azimuths = AzimuthCount(Lean(), 1.5 * resolution_.azimuths_per_kappa);
  const auto& directions = layer_.kappa > 1.0 ? faces_.fine_directions : faces_.directions;
  for (const Direction& d : directions) {
    for (int j = 0; j < azimuths; ++j) {
      const double cos_azimuth = CosineOfAzimuth(j, azimuths), weight = d.weight / azimuths;
      const Complex q = Rate(d, cos_azimuth);
      AddSingleScattering(d, q, weight);
      AddStraightLight(d, q, cos_azimuth, weight);
    }
  }
}

ExactResponses Galerkin::Solve() {
  AddFreeKernel(mesh_, layer_.kappa, resolution_.free_nodes, kernel_);
  AddFaces();
  AddClosedForms();
  const double albedo = layer_.albedo;
  const Eigen::MatrixXd system = Eigen::MatrixXd::Identity(mesh_.Size(), mesh_.Size()) - albedo * kernel_;
  const Eigen::LDLT<Eigen::MatrixXd> solver(system);
  // By symmetry of the kernel one solution for each way out serves every way in.
  const Eigen::VectorXd top = solver.solve(leave_top_), bottom = solver.solve(leave_bottom_);
  const Eigen::VectorXd normal = NormalLight();

  ExactResponses r;
  r.r_normal_single = albedo * single_back_;
  r.r_normal = albedo * (single_back_ + (top - leave_top_).dot(normal));
  r.r_down = (albedo * top.dot(enter_top_) + mirrored_down_) / flux_top_;
  if (!IsSlab()) return r;
  r.t_normal = albedo * (single_through_ + (bottom - leave_bottom_).dot(normal));
  const double across = std::exp(-tau_);
  const double bounces = 1.0 / (1.0 - faces_.normal_top * faces_.normal_bottom * across * across);
  r.t_ballistic = (1.0 - faces_.normal_bottom) * across * bounces;
  r.r_ballistic = (1.0 - faces_.normal_top) * faces_.normal_bottom * across * across * bounces;
  r.t_down = (albedo * bottom.dot(enter_top_) + straight_down_) / flux_top_;
  r.r_up = (albedo * bottom.dot(enter_bottom_) + mirrored_up_) / flux_bottom_;
  r.t_up = (albedo * top.dot(enter_bottom_) + straight_up_) / flux_bottom_;
  return r;
}

}  // namespace

ExactResponses SolveExactLayer(const ExactFaces& faces, const ExactLayer& layer,
                               const ExactResolution& resolution) {
  assert(layer.albedo >= 0.0 && layer.albedo <= 1.0 && layer.kappa >= 0.0);
  assert(faces.half_space || layer.thickness > 0.0);
  return Galerkin(faces, layer, resolution).Solve();
}

}  // namespace dermap
