// SPDX-License-Identifier: Apache-2.0
// The reference for small patches: Levenberg-Marquardt with the dense Jacobian.
#include <ceres/cost_function.h>
#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "fit/ceres_reference.h"
#include "fit/ceres_stop.h"
#include "fit/map_steps.h"

namespace dermap {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Residuals: the data band by band, then what the prior says of each octave and parameter. One block of
// parameters: the planes of the position one after the other.
class DenseFunction final : public ceres::CostFunction {
 public:
  DenseFunction(const Posterior& posterior, const DetailView& detail)
      : posterior_(posterior), data_(posterior.problem().data()), scatter_(detail.scatter[0]) {
    pixels_ = data_.fitted.size();
    count_ = posterior.problem().space().count();
    MakePriorRows();
    set_num_residuals(static_cast<int>(data_.bands.size() * pixels_) + static_cast<int>(prior_.rows()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(count_ * pixels_));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Posterior::Position position = PositionOf(parameters[0]);
    const ParameterMaps maps = posterior_.MapsOf(position);
    const ForwardModel& model = posterior_.problem().model();
    const std::vector<PlaneF> predicted = model.Render(maps);
    const int unknowns = static_cast<int>(count_ * pixels_);
    Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
    const Eigen::Map<const Eigen::VectorXd> at(parameters[0], unknowns);
    std::vector<double> weights(data_.bands.size() * pixels_, 0.0);
    for (std::size_t b = 0; b < data_.bands.size(); ++b)
      for (std::size_t i = 0; i < pixels_; ++i) {
        const std::size_t row = b * pixels_ + i;
        out[static_cast<int>(row)] = 0.0;
        if (!data_.fitted.data()[i] || !data_.Has(static_cast<int>(b), i)) continue;
        const double reflectance = std::max(static_cast<double>(predicted[b].data()[i]), 1e-7);
        const LogResidual datum =
            LogResidualOf(data_.measured[b].data()[i], data_.sigma[b].data()[i], reflectance);
        out[static_cast<int>(row)] = -datum.residual / std::sqrt(scatter_);
        weights[row] = datum.weight / reflectance / std::sqrt(scatter_);
      }
    out.tail(prior_.rows()) = prior_ * at - prior_mean_;
    if (!jacobians || !jacobians[0]) return true;
    Eigen::Map<RowMajor> jacobian(jacobians[0], num_residuals(), unknowns);
    jacobian.setZero();
    jacobian.bottomRows(prior_.rows()) = prior_;
    const ParameterSpace& space = posterior_.problem().space();
    const ForwardModel::Kept render(model, maps);
    for (int column = 0; column < unknowns; ++column) {
      const auto pixel = static_cast<std::size_t>(column) % pixels_;
      const ParameterMaps change =
          ChangeOfPixel(space, column / static_cast<int>(pixels_), pixel, data_.width(), data_.height());
      const std::vector<PlaneF> response = render.Tangent(change);
      for (std::size_t b = 0; b < response.size(); ++b)
        for (std::size_t i = 0; i < pixels_; ++i)
          jacobian(static_cast<int>(b * pixels_ + i), column) =
              weights[b * pixels_ + i] * response[b].data()[i];
    }
    return true;
  }

  Posterior::Position PositionOf(const double* values) const {
    Posterior::Position position(count_, PlaneF(data_.width(), data_.height()));
    for (std::size_t j = 0; j < count_; ++j)
      for (std::size_t i = 0; i < pixels_; ++i)
        position[j].data()[i] = static_cast<float>(values[j * pixels_ + i]);
    return position;
  }

 private:
  // The prior is half a square of a linear map of the position: its Hessian, column by column from gradients,
  // and the Cholesky factor of that.
  void MakePriorRows() {
    const int unknowns = static_cast<int>(count_ * pixels_);
    Posterior::Position zero(count_, PlaneF(data_.width(), data_.height())), gradient, at_zero;
    posterior_.PriorValueAndGradient(zero, at_zero);
    Eigen::MatrixXd hessian(unknowns, unknowns);
    Eigen::VectorXd slope(unknowns);
    for (int column = 0; column < unknowns; ++column) {
      const std::size_t j = static_cast<std::size_t>(column) / pixels_,
                        i = static_cast<std::size_t>(column) % pixels_;
      slope[column] = at_zero[j].data()[i];
      zero[j].data()[i] = 1.0f;
      posterior_.PriorValueAndGradient(zero, gradient);
      zero[j].data()[i] = 0.0f;
      for (std::size_t k = 0; k < count_; ++k)
        for (std::size_t p = 0; p < pixels_; ++p)
          hessian(static_cast<int>(k * pixels_ + p), column) =
              static_cast<double>(gradient[k].data()[p]) - at_zero[k].data()[p];
    }
    hessian = 0.5 * (hessian + hessian.transpose().eval());
    hessian.diagonal().array() += 1e-6 * hessian.diagonal().mean();  // rounding of float planes
    const Eigen::LLT<Eigen::MatrixXd> factor(hessian);
    prior_ = factor.matrixU();
    prior_mean_ = factor.matrixL().solve(-slope);
  }

  const Posterior& posterior_;
  const FitData& data_;
  double scatter_;
  std::size_t pixels_ = 0, count_ = 0;
  RowMajor prior_;  // its square is the prior's Hessian
  Eigen::VectorXd prior_mean_;
};

}  // namespace

ReferenceOutcome MinimiseDense(const Posterior& posterior, const DetailView& detail,
                               const ParameterMaps& start, int max_iterations, RunLog& log) {
  const ParameterSpace& space = posterior.problem().space();
  auto* function = new DenseFunction(posterior, detail);
  std::vector<double> values;
  const Posterior::Position at = posterior.PositionOf(start);
  for (const PlaneF& plane : at) values.insert(values.end(), plane.values().begin(), plane.values().end());
  ceres::Problem problem;
  problem.AddResidualBlock(function, nullptr, values.data());  // owns it
  const std::size_t pixels = at[0].size();
  for (std::size_t k = 0; k < values.size(); ++k) {
    const int j = static_cast<int>(k / pixels);
    values[k] = std::clamp(values[k], space.lower()[j], space.upper()[j]);
    problem.SetParameterLowerBound(values.data(), static_cast<int>(k), space.lower()[j]);
    problem.SetParameterUpperBound(values.data(), static_cast<int>(k), space.upper()[j]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-6;
  options.logging_type = ceres::SILENT;
  const auto stop = StopWhenAsked(log);
  options.callbacks.push_back(stop.get());
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  log.Progress(1.0);

  ReferenceOutcome outcome;
  outcome.maps = posterior.MapsOf(function->PositionOf(values.data()));
  outcome.converged = summary.termination_type == ceres::CONVERGENCE;
  outcome.objective = summary.final_cost;
  outcome.evaluations = summary.num_residual_evaluations;
  const int unknowns = static_cast<int>(values.size());
  RowMajor jacobian(function->num_residuals(), unknowns);
  Eigen::VectorXd residuals(function->num_residuals());
  const double* block = values.data();
  double* rows = jacobian.data();
  function->Evaluate(&block, residuals.data(), &rows);
  const Eigen::MatrixXd covariance = (jacobian.transpose() * jacobian)
                                         .selfadjointView<Eigen::Lower>()
                                         .llt()
                                         .solve(Eigen::MatrixXd::Identity(unknowns, unknowns));
  outcome.variance.assign(at.size(), PlaneF(at[0].width(), at[0].height()));
  for (int k = 0; k < unknowns; ++k)
    outcome.variance[static_cast<std::size_t>(k) / pixels].data()[static_cast<std::size_t>(k) % pixels] =
        static_cast<float>(covariance(k, k));
  return outcome;
}

}  // namespace dermap
