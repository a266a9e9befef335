// SPDX-License-Identifier: Apache-2.0
// Least squares by Ceres, one problem a candidate; then the likelihoods side by side.
#include "fit/spectra/spectrum_fit.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>

#include "fit/spectra/model_choice.h"

namespace dermap {
namespace {

constexpr int kStride = 8;  // derivatives in one pass; no candidate frees more than 7 parameters

// Residuals over sigma, as a function of the free parameters alone.
struct Misfit {
  const SpectrumModel& model;
  const SkinModel& candidate;
  std::span<const double> reflectance, sigma;

  template <class Scalar>
  bool operator()(Scalar const* const* blocks, Scalar* residuals) const {
    std::array<Scalar, kSkinParameterCount> skin;
    for (int i = 0; i < kSkinParameterCount; ++i) skin[i] = Scalar(candidate.fixed[i]);
    for (std::size_t i = 0; i < candidate.free.size(); ++i)
      skin[static_cast<int>(candidate.free[i])] = blocks[0][i];
    model.Predict(skin, residuals);
    for (std::size_t i = 0; i < reflectance.size(); ++i) {
      residuals[i] = (residuals[i] - reflectance[i]) / sigma[i];
    }
    return true;
  }
};

std::unique_ptr<ceres::CostFunction> MakeCost(const Misfit& misfit) {
  auto cost = std::make_unique<ceres::DynamicAutoDiffCostFunction<Misfit, kStride>>(new Misfit(misfit));
  cost->AddParameterBlock(static_cast<int>(misfit.candidate.free.size()));
  cost->SetNumResiduals(static_cast<int>(misfit.reflectance.size()));
  return cost;
}

struct Solution {
  std::vector<double> x;
  double cost = std::numeric_limits<double>::infinity();
  bool converged = false;
};

Solution Solve(const Misfit& misfit, const SkinVector& start) {
  Solution solution;
  ceres::Problem problem;
  for (const SkinParameter p : misfit.candidate.free) {
    // A start on a bound has no way to move but one: begin a little inside.
    const SkinParameterInfo& info = InfoOf(p);
    const double margin = 0.02 * (info.upper - info.lower);
    solution.x.push_back(std::clamp(start[static_cast<int>(p)], info.lower + margin, info.upper - margin));
  }
  problem.AddResidualBlock(MakeCost(misfit).release(), nullptr, solution.x.data());
  for (std::size_t i = 0; i < solution.x.size(); ++i) {
    const SkinParameterInfo& info = InfoOf(misfit.candidate.free[i]);
    problem.SetParameterLowerBound(solution.x.data(), static_cast<int>(i), info.lower);
    problem.SetParameterUpperBound(solution.x.data(), static_cast<int>(i), info.upper);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-6;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  solution.cost = summary.final_cost;
  solution.converged = summary.termination_type == ceres::CONVERGENCE;
  return solution;
}

// Average, dark and pale skin; or average skin and the best that a smaller model has found.
std::vector<SkinVector> Starts(const SkinModel& candidate, const SkinVector* smaller) {
  std::vector<SkinVector> starts;
  for (const double C_m : {0.04, 0.2, 0.01}) {
    if (smaller != nullptr && !starts.empty()) break;
    SkinVector start = candidate.fixed;
    start[static_cast<int>(SkinParameter::kC_m)] = C_m;
    start[static_cast<int>(SkinParameter::kC_hd)] = 0.015;
    start[static_cast<int>(SkinParameter::kVesselRadius)] = 0.01;
    starts.push_back(start);
  }
  if (smaller != nullptr) starts.push_back(*smaller);
  return starts;
}

// Curvature of the misfit where it is least. What the data do not tell is known to its range.
void AddSigma(const Misfit& misfit, double inflation, const Solution& solution, ModelFit& fit) {
  const int count = static_cast<int>(solution.x.size());
  const int bands = static_cast<int>(misfit.reflectance.size());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows jacobian(bands, count);
  std::vector<double> residuals(bands);
  const double* x = solution.x.data();
  double* rows = jacobian.data();
  MakeCost(misfit)->Evaluate(&x, residuals.data(), &rows);
  for (int i = 0; i < bands; ++i) {
    const double noise = misfit.sigma[i];
    jacobian.row(i) *= noise / std::sqrt((noise * noise + fit.discrepancy * fit.discrepancy) * inflation);
  }
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  for (int i = 0; i < count; ++i) {
    const SkinParameter p = misfit.candidate.free[i];
    const double range = InfoOf(p).upper - InfoOf(p).lower;
    information(i, i) += 1.0 / (range * range);
    const double slack = 1e-4 * range;
    if (x[i] > InfoOf(p).lower + slack && x[i] < InfoOf(p).upper - slack) continue;
    fit.at_bound.push_back(p);
    information.row(i).setZero();
    information.col(i).setZero();
    information(i, i) = 1.0;
  }
  const Eigen::MatrixXd covariance = information.ldlt().solve(Eigen::MatrixXd::Identity(count, count));
  for (int i = 0; i < count; ++i) {
    const SkinParameter p = misfit.candidate.free[i];
    if (std::find(fit.at_bound.begin(), fit.at_bound.end(), p) != fit.at_bound.end()) continue;
    const double sigma = std::sqrt(std::max(covariance(i, i), 0.0));
    fit.sigma[static_cast<int>(p)] = sigma;
    if (sigma > 0.5 * (InfoOf(p).upper - InfoOf(p).lower)) fit.not_identifiable.push_back(p);
  }
}

bool Contains(const SkinModel& larger, const SkinModel& smaller) {
  return smaller.fixed == larger.fixed && smaller.free.size() < larger.free.size() &&
         std::all_of(smaller.free.begin(), smaller.free.end(), [&](SkinParameter p) {
           return std::find(larger.free.begin(), larger.free.end(), p) != larger.free.end();
         });
}

std::vector<double> Residuals(std::span<const double> measured, const ModelFit& fit) {
  std::vector<double> residuals;
  for (std::size_t i = 0; i < measured.size(); ++i) residuals.push_back(measured[i] - fit.predicted[i]);
  return residuals;
}

// The best of some starts.
Solution SolveFromStarts(const Misfit& misfit, const std::vector<ModelFit>& done) {
  const SkinVector* smaller = nullptr;
  for (const ModelFit& known : done) {
    if (Contains(misfit.candidate, known.model)) smaller = &known.skin;
  }
  Solution best;
  for (const SkinVector& start : Starts(misfit.candidate, smaller)) {
    Solution solution = Solve(misfit, start);
    if (solution.cost < best.cost) best = std::move(solution);
  }
  return best;
}

ModelFit Describe(const Misfit& misfit, const Solution& solution) {
  ModelFit fit;
  fit.model = misfit.candidate;
  fit.skin = fit.model.fixed;
  for (std::size_t i = 0; i < solution.x.size(); ++i)
    fit.skin[static_cast<int>(fit.model.free[i])] = solution.x[i];
  fit.converged = solution.converged;
  fit.predicted.resize(misfit.reflectance.size());
  misfit.model.Predict(fit.skin, fit.predicted.data());
  return fit;
}

}  // namespace

SpectrumFit FitSpectrum(const SpectrumModel& model, std::span<const double> reflectance,
                        std::span<const double> sigma, std::span<const SkinModel> candidates) {
  SpectrumFit result;
  std::vector<Solution> solutions;
  for (const SkinModel& candidate : candidates) {
    const Misfit misfit{model, candidate, reflectance, sigma};
    solutions.push_back(SolveFromStarts(misfit, result.candidates));
    result.candidates.push_back(Describe(misfit, solutions.back()));
  }
  // Evidence is counted alike for all candidates: by the residual of the one that fits best.
  const auto closest = std::min_element(solutions.begin(), solutions.end(),
                                        [](const Solution& a, const Solution& b) { return a.cost < b.cost; });
  result.effective_count =
      EffectiveCount(Residuals(reflectance, result.candidates[closest - solutions.begin()]));
  const double inflation = static_cast<double>(reflectance.size()) / result.effective_count;
  for (std::size_t i = 0; i < result.candidates.size(); ++i) {
    ModelFit& fit = result.candidates[i];
    const Evidence evidence =
        WeighEvidence(Residuals(reflectance, fit), sigma, fit.model.free.size(), result.effective_count);
    fit.rms = evidence.rms;
    fit.discrepancy = evidence.discrepancy;
    fit.bic = evidence.bic;
    AddSigma({model, fit.model, reflectance, sigma}, inflation, solutions[i], fit);
    if (fit.bic < result.candidates[result.chosen].bic) result.chosen = i;
  }
  return result;
}

}  // namespace dermap
