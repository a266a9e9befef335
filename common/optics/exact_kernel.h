// SPDX-License-Identifier: Apache-2.0
// Matrices of the integral equation of exact_layer.h in the basis of exact_mesh.h.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/optics/exact_mesh.h"

namespace dermap {

using KernelMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Adds the kernel without faces.
void AddFreeKernel(const DepthMesh& mesh, double kappa, int nodes, KernelMatrix& kernel);

// Sums of products of columns, kernel += sum over c of left[c] right[c]': gathered first, multiplied at once.
class ColumnProducts {
 public:
  explicit ColumnProducts(int size) : size_(size) {}
  // Re[outer (factor inner + other_factor other)'], all complex.
  using Column = std::vector<std::complex<double>>;
  void Add(const Column& outer, std::complex<double> factor, const Column& inner,
           std::complex<double> other_factor, const Column& other);
  void AddTo(KernelMatrix& kernel);

 private:
  int size_;
  std::vector<double> left_, right_;
};

// A complex product without the standard's care for infinities.
inline std::complex<double> Product(const std::complex<double>& a, const std::complex<double>& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

}  // namespace dermap
