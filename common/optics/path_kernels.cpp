// SPDX-License-Identifier: Apache-2.0
// Sums of exponentials of absorption, fitted to transforms over a scene's range.
#include "common/optics/path_kernels.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "common/optics/profile_table.h"

namespace dermap {
namespace {

constexpr double kFloor =
    1e-4;  // share of the incident light below which an error no longer counts as relative
constexpr double kRidge = 1e-6;  // keeps what the absorptions cannot tell apart from growing
constexpr int kSamples = 24;     // absorptions at which the sum is fitted and checked

// The longest path that still matters is a few times 1 / lowest mu_a, the shortest a fraction of 1 / highest.
constexpr double kShortestDepth = 0.3, kLongestDepth = 2.5;

using Matrix = Eigen::MatrixXd;

Matrix Exponentials(std::span<const double> mu_a, std::span<const double> lengths_mm) {
  Matrix e(mu_a.size(), lengths_mm.size());
  for (Eigen::Index i = 0; i < e.rows(); ++i)
    for (Eigen::Index j = 0; j < e.cols(); ++j) e(i, j) = std::exp(-mu_a[i] * lengths_mm[j]);
  return e;
}

// Weighted least squares with a ridge: coefficients (lengths x frequencies) for values (absorptions x
// frequencies).
Matrix Fit(const Matrix& exponentials, const Matrix& values, const Eigen::VectorXd& weights) {
  const Eigen::Index rows = exponentials.rows(), columns = exponentials.cols();
  Matrix system(rows + columns, columns), right(rows + columns, values.cols());
  system << weights.asDiagonal() * exponentials, kRidge * Matrix::Identity(columns, columns);
  right << weights.asDiagonal() * values, Matrix::Zero(columns, values.cols());
  return system.householderQr().solve(right);
}

std::vector<double> Geometric(double first, double last, int count) {
  std::vector<double> values(count, std::sqrt(first * last));
  for (int i = 0; count > 1 && i < count; ++i) values[i] = first * std::pow(last / first, i / (count - 1.0));
  return values;
}

Matrix ValuesAt(const TransformTable& table, std::span<const double> mu_a) {
  Matrix values(mu_a.size(), TableFrequencies_per_mm().size());
  for (std::size_t i = 0; i < mu_a.size(); ++i) {
    const std::vector<double> row = table.At(mu_a[i]);
    values.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::RowVectorXd>(row.data(), static_cast<Eigen::Index>(row.size()));
  }
  return values;
}

std::vector<std::vector<float>> RowsOf(const Matrix& coefficients) {
  std::vector<std::vector<float>> rows(coefficients.rows());
  for (Eigen::Index j = 0; j < coefficients.rows(); ++j)
    for (Eigen::Index k = 0; k < coefficients.cols(); ++k)
      rows[j].push_back(static_cast<float>(coefficients(j, k)));
  return rows;
}

Eigen::VectorXd OwnWeights(const Matrix& values) {
  return values.col(0).cwiseMax(kFloor).cwiseInverse();
}

// Values (absorptions x frequencies) by exponentials (absorptions x lengths). The error counts what single
// precision makes of terms that nearly cancel: too many lengths are no better than too few.
PathFit FitSamples(const Matrix& values, const Matrix& exponentials, const Eigen::VectorXd& weights) {
  constexpr double kRounding = 2e-7;
  const Matrix coefficients = Fit(exponentials, values, weights);
  const Matrix misfit =
      (exponentials * coefficients - values).cwiseAbs() + kRounding * exponentials * coefficients.cwiseAbs();
  const Eigen::RowVectorXd errors = (weights.asDiagonal() * misfit).colwise().maxCoeff();
  return {RowsOf(coefficients), {errors.begin(), errors.end()}};
}

}  // namespace

namespace {

// Calls use(entry, weight) for the four entries of the tables around mu_a.
template <class Use>
void ForEntries(double mu_a, const Use& use) {
  static const double step = std::log(TableMuA(1) / TableMuA(0));
  const double position = std::log(std::clamp(mu_a, kTableMinMuA, kTableMaxMuA) / kTableMinMuA) / step;
  const int first = std::clamp(static_cast<int>(position) - 1, 0, kTableSize - 4);
  for (int i = 0; i < 4; ++i) {
    double weight = 1.0;
    for (int j = 0; j < 4; ++j)
      if (j != i) weight *= (position - first - j) / (i - j);
    use(static_cast<std::size_t>(first + i), weight);
  }
}

}  // namespace

std::vector<double> TransformTable::At(double mu_a) const {
  const std::size_t frequencies = TableFrequencies_per_mm().size();
  std::vector<double> values(frequencies, 0.0);
  ForEntries(mu_a, [&](std::size_t entry, double weight) {
    for (std::size_t k = 0; k < frequencies; ++k) values[k] += weight * values_[entry * frequencies + k];
  });
  return values;
}

double TransformTable::At(double mu_a, std::size_t frequency) const {
  const std::size_t frequencies = TableFrequencies_per_mm().size();
  double value = 0.0;
  ForEntries(mu_a, [&](std::size_t entry, double weight) {
    value += weight * values_[entry * frequencies + frequency];
  });
  return value;
}

PathFit FitPaths(const TransformTable& response, std::span<const double> lengths_mm, double lowest,
                 double highest) {
  assert(lowest > 0.0 && highest >= lowest);
  const std::vector<double> samples = Geometric(lowest, highest, kSamples);
  const Matrix values = ValuesAt(response, samples);
  return FitSamples(values, Exponentials(samples, lengths_mm), OwnWeights(values));
}

ScenePaths ReducePaths(std::span<const TransformTable* const> responses, double lowest, double highest,
                       double tolerance, int count, const ErrorWeight& weight) {
  assert(lowest > 0.0 && highest >= lowest);
  assert(count >= 0 && count <= kMostPaths);
  const std::vector<double> samples = Geometric(lowest, highest, kSamples);
  std::vector<Matrix> values;
  std::vector<Eigen::VectorXd> weights;
  for (std::size_t r = 0; r < responses.size(); ++r) {
    values.push_back(ValuesAt(*responses[r], samples));
    weights.push_back(OwnWeights(values.back()));
    for (int i = 0; weight && i < kSamples; ++i) weights.back()[i] = weight(r, samples[i]);
  }
  ScenePaths best;
  const int first = count > 0 ? count : 1, last = count > 0 ? count : kMostPaths;
  for (int tried = first; tried <= last; ++tried) {
    ScenePaths paths;
    paths.lengths_mm = Geometric(kShortestDepth / highest, kLongestDepth / lowest, tried);
    const Matrix few = Exponentials(samples, paths.lengths_mm);
    for (std::size_t r = 0; r < values.size(); ++r) {
      PathFit fit = FitSamples(values[r], few, weights[r]);
      paths.error = std::max(paths.error, *std::max_element(fit.errors.begin(), fit.errors.end()));
      paths.kernels.push_back(std::move(fit.kernels));
    }
    if (tried == first || paths.error < best.error) best = std::move(paths);
    if (best.error <= tolerance) break;
  }
  return best;
}

}  // namespace dermap
