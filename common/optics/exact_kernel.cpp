// SPDX-License-Identifier: Apache-2.0
// The kernel without faces from real exponentials; the faces' part from products of columns.
#include "common/optics/exact_kernel.h"

#include <cmath>

#include "common/core/kernel.h"
#include "common/optics/gauss_legendre.h"

namespace dermap {
namespace {

using Block = Eigen::Matrix<double, kElementModes, kElementModes, Eigen::RowMajor>;

// Over the pseudo-angle psi, sin(psi) = kappa * nu, the kernel without faces is a sum of real exponentials at
// every kappa: K_0(x) = 1/2 int_0^{atan kappa} dpsi / sin(psi) exp(-kappa x / sin(psi)).
struct RealExponentials {
  std::vector<double> rates, weights;
};
RealExponentials FreeExponentials(double kappa, int nodes) {
  static thread_local QuadratureRule rule;
  if (static_cast<int>(rule.nodes.size()) != nodes) rule = GaussLegendreRule(nodes, 0.0, 1.0);
  const bool flat = kappa < 1e-6;
  const double widest = std::atan(kappa);
  RealExponentials free;
  for (int m = 0; m < nodes; ++m) {
    const double nu = flat ? rule.nodes[m] : std::sin(rule.nodes[m] * widest) / kappa;
    const double span = flat ? 1.0 : widest / kappa;
    free.rates.push_back(1.0 / nu);
    free.weights.push_back(0.5 * rule.weights[m] * span / nu);
  }
  return free;
}

// sum[i][j] += sum over c of left[c][i] * right[c][j], c a multiple of 4. A plain loop that vectorises over
// j.
DERMAP_KERNEL void AddProducts(const double* left, const double* right, int columns, int size, double* sum) {
  for (int c = 0; c < columns; c += 4) {
    const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(c) * size;
    const double *l = left + start, *r = right + start;
    for (int i = 0; i < size; ++i) {
      const double a = l[i], b = l[size + i], d = l[2 * size + i], e = l[3 * size + i];
      double* row = sum + static_cast<std::ptrdiff_t>(i) * size;
      for (int j = 0; j < size; ++j) {
        row[j] += a * r[j] + b * r[size + j] + d * r[2 * size + j] + e * r[3 * size + j];
      }
    }
  }
}

}  // namespace

void AddFreeKernel(const DepthMesh& mesh, double kappa, int node_count, KernelMatrix& kernel) {
  const RealExponentials free = FreeExponentials(kappa, node_count);
  const int elements = mesh.ElementCount();
  std::vector<ExponentialMoments<double>> moments(static_cast<std::size_t>(elements) * node_count);
  const auto moment = [&](int element, int node) -> ExponentialMoments<double>& {
    return moments[static_cast<std::size_t>(element) * node_count + node];
  };
  for (int e = 0; e < elements; ++e) {
    for (int m = 0; m < node_count; ++m) moment(e, m) = MomentsOfExponential(free.rates[m], mesh.Height(e));
  }
  for (int a = 0; a < elements; ++a) {
    auto own = kernel.block<kElementModes, kElementModes>(a * kElementModes, a * kElementModes);
    for (int m = 0; m < node_count; ++m) {
      const SelfMoments self = SelfMomentsOfExponential(free.rates[m], mesh.Height(a), moment(a, m));
      own += free.weights[m] * Eigen::Map<const Block>(self.data());
    }
    std::vector<double> gap = free.weights;  // times exp(-rate * gap between the elements)
    for (int b = a + 1; b < elements; ++b) {
      Block pair = Block::Zero();
      for (int m = 0; m < node_count; ++m) {
        const auto& above = moment(a, m).values;  // from the element's lower end: odd ones change sign
        const Eigen::Map<const Eigen::Vector4d> below(moment(b, m).values.data());
        pair += Eigen::Vector4d(above[0], -above[1], above[2], -above[3]) * (gap[m] * below).transpose();
        gap[m] *= moment(b, m).fall;
      }
      kernel.block<kElementModes, kElementModes>(a * kElementModes, b * kElementModes) += pair;
      kernel.block<kElementModes, kElementModes>(b * kElementModes, a * kElementModes) += pair.transpose();
    }
  }
}

// Re[a x] of complex columns as two products of real ones.
void ColumnProducts::Add(const Column& outer, std::complex<double> factor, const Column& inner,
                         std::complex<double> other_factor, const Column& other) {
  const std::size_t size = outer.size(), start = left_.size();
  left_.resize(start + 2 * size);
  right_.resize(start + 2 * size);
  for (std::size_t i = 0; i < size; ++i) {
    const std::complex<double> x = Product(factor, inner[i]) + Product(other_factor, other[i]);
    left_[start + i] = outer[i].real();
    left_[start + size + i] = -outer[i].imag();
    right_[start + i] = x.real();
    right_[start + size + i] = x.imag();
  }
}

void ColumnProducts::AddTo(KernelMatrix& kernel) {
  const std::size_t columns = left_.size() / size_, padded = (columns + 3) / 4 * 4;
  left_.resize(padded * size_, 0.0);
  right_.resize(padded * size_, 0.0);
  AddProducts(left_.data(), right_.data(), static_cast<int>(padded), size_, kernel.data());
}

}  // namespace dermap
