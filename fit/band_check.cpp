// SPDX-License-Identifier: Apache-2.0
// The mean spectrum with each band left out.
#include "fit/band_check.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "fit/octave_solver.h"

namespace dermap {
namespace {

// chi2 of the mean above which there is something to find. With one or two bands more than it takes, some
// band can always be found without which the rest agrees: then only more than errors of all bands (0.7 % at a
// shared error of 0.1 %) would do speaks for a single one.
constexpr double kMisfit = 12.0, kMisfitOfFew = 100.0;
constexpr int kFewToSpare = 2;
constexpr double kMostlyExplained = 0.25;  // of it may stay when the suspect is left out

struct MeanFit {
  double chi2 = 0.0;
  Eigen::VectorXd residual;  // of the logarithms, of all bands, those left out too
};

// Least squares of the mean spectrum without one band (-1: with all).
MeanFit FitMean(const Eigen::MatrixXd& rows, const Eigen::VectorXd& residual, const Eigen::VectorXd& weight,
                int without) {
  Eigen::VectorXd used = weight;
  if (without >= 0) used[without] = 0.0;
  Eigen::MatrixXd normal = rows.transpose() * used.asDiagonal() * rows;
  normal.diagonal().array() += 1.0;  // the range, scaled units
  const Eigen::VectorXd change = normal.llt().solve(rows.transpose() * (used.asDiagonal() * residual));
  MeanFit fit;
  fit.residual = residual - rows * change;
  fit.chi2 = used.dot(fit.residual.cwiseAbs2());
  return fit;
}

}  // namespace

std::optional<SuspectBand> FindSuspectBand(const PatchProblem& problem,
                                           const std::vector<OctaveLevel>& levels, const DetailView& detail,
                                           const SkinPoint& fixed, double smallest) {
  const OctaveLevel& mean = levels.back();
  const int bands = problem.data().band_count(), count = problem.space().count();
  if (bands < count + 2) return std::nullopt;
  std::vector<OctaveRow> filled(bands);
  RowMaker(problem, mean, nullptr, fixed).Fill(0, filled);
  Eigen::MatrixXd rows(bands, count);
  Eigen::VectorXd residual(bands), weight(bands);
  for (int b = 0; b < bands; ++b) {
    for (int j = 0; j < count; ++j) rows(b, j) = filled[b].unblurred[j];
    residual[b] = mean.residual[b].data()[0];
    const double noise = mean.noise_inflation * detail.scatter[0] / mean.weight[b].data()[0];
    weight[b] = std::isfinite(noise) ? 1.0 / noise : 0.0;
  }
  const double all = FitMean(rows, residual, weight, -1).chi2;
  if (all < (bands - count > kFewToSpare ? kMisfit : kMisfitOfFew)) return std::nullopt;
  SuspectBand suspect;
  double least = all;
  for (int b = 0; b < bands; ++b) {
    const MeanFit fit = FitMean(rows, residual, weight, b);
    if (fit.chi2 >= least) continue;
    least = fit.chi2;
    suspect = {b, std::expm1(fit.residual[b]), 0.5 * (all - fit.chi2)};
  }
  if (least > kMostlyExplained * all || std::abs(suspect.gain_error) < smallest) return std::nullopt;
  return suspect;
}

double ShareOfGains(const FitData& data, const FitState& state) {
  double explained = 0.0;
  for (int b = 0; b < data.band_count(); ++b) {
    double weights = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < data.fitted.size(); ++i) {
      if (!data.fitted.data()[i] || !data.Has(b, i)) continue;
      const LogResidual datum =
          LogResidualOf(data.measured[b].data()[i], data.sigma[b].data()[i], state.predicted[b].data()[i]);
      weights += datum.weight * datum.weight;
      sum += datum.weight * datum.residual;
    }
    if (weights > 0.0) explained += sum * sum / weights;
  }
  return explained / state.misfit.chi2;
}

double GainError(const FitData& data, int band, const PlaneF& predicted) {
  double measured_sum = 0.0, predicted_sum = 0.0;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    if (!data.fitted.data()[i] || !data.Has(band, i)) continue;
    measured_sum += data.measured[band].data()[i];
    predicted_sum += predicted.data()[i];
  }
  return measured_sum / predicted_sum - 1.0;
}

}  // namespace dermap
