// SPDX-License-Identifier: Apache-2.0
// Non-negative least squares fits of 18 Gaussians to a transform [D08 eq. 4, 7].
//
// Fitted is the transform divided by its total, all frequencies weighted alike but the first, so that a
// misfit counts as what it does to an image's spectrum. A profile that is a mixture of Gaussians of 0.01
// to 3.6 mm, its transform completely monotonic in k^2, is met within 1e-5 of its total. Not every profile
// is: see profile_table.h.
#include "common/optics/gaussian_sum.h"

#include <Eigen/QR>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "common/optics/nnls.h"

namespace dermap {

namespace {
constexpr double kTotalRowWeight =
    10.0;  // the total is made exact afterwards; this keeps what that changes small
}

// Least squares by the triangle R of a QR factorisation: as well conditioned as by the full matrix, and a
// quarter of its rows.
struct GaussianFitter::Prepared {
  Eigen::MatrixXd q_transposed;  // kGaussianCount x frequencies; the row weights are in it
  Eigen::MatrixXd r;             // kGaussianCount x the Gaussians in use
  int step = 1;
};

GaussianFitter::GaussianFitter(std::span<const double> k_per_mm, int step) {
  const auto rows = static_cast<Eigen::Index>(k_per_mm.size());
  assert(rows >= kGaussianCount && k_per_mm[0] == 0.0 && step > 0);
  Eigen::MatrixXd gaussians(rows, kGaussianCount);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double weight = row == 0 ? kTotalRowWeight : 1.0;
    for (int i = 0; i < kGaussianCount; ++i) {
      gaussians(row, i) = weight * std::exp(-0.5 * GaussianVariance_mm2(i) * k_per_mm[row] * k_per_mm[row]);
    }
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(gaussians);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(rows, kGaussianCount);
  auto prepared = std::make_unique<Prepared>();
  prepared->q_transposed = q.transpose();
  prepared->q_transposed.col(0) *= kTotalRowWeight;
  const Eigen::MatrixXd r = qr.matrixQR().topRows(kGaussianCount).triangularView<Eigen::Upper>();
  prepared->r = r(Eigen::all, Eigen::seq(0, kGaussianCount - 1, step));
  prepared->step = step;
  prepared_ = std::move(prepared);
}

GaussianFitter::~GaussianFitter() = default;

GaussianWeights GaussianFitter::Fit(std::span<const double> transform, const GaussianWeights& similar) const {
  assert(static_cast<Eigen::Index>(transform.size()) == prepared_->q_transposed.cols());
  GaussianWeights weights{};
  const double total = transform[0];
  if (!(total > 0.0)) return weights;
  const Eigen::Map<const Eigen::VectorXd> profile(transform.data(),
                                                  static_cast<Eigen::Index>(transform.size()));
  const Eigen::VectorXd shape = prepared_->q_transposed * (profile / total);
  const Eigen::Map<const Eigen::Matrix<float, kGaussianCount, 1>> start(similar.data());
  const auto used = Eigen::seq(0, kGaussianCount - 1, prepared_->step);
  const Eigen::VectorXd fitted = SolveNonNegative(prepared_->r, shape, start(used).cast<double>() / total);
  const double sum = fitted.sum();
  assert(sum > 0.0);
  for (Eigen::Index i = 0; i < fitted.size(); ++i)
    weights[i * prepared_->step] = static_cast<float>(fitted[i] * total / sum);
  return weights;
}

GaussianWeights FitGaussianSum(std::span<const double> k_per_mm, std::span<const double> transform) {
  return GaussianFitter(k_per_mm).Fit(transform);
}

double GaussianSumTransform(const GaussianWeights& weights, double k_per_mm) {
  double sum = 0.0;
  for (int i = 0; i < kGaussianCount; ++i) {
    sum += weights[i] * std::exp(-0.5 * GaussianVariance_mm2(i) * k_per_mm * k_per_mm);
  }
  return sum;
}

}  // namespace dermap
