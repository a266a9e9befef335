// SPDX-License-Identifier: Apache-2.0
// The reference for any size: Ceres's gradient-only solver.
#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <ceres/iteration_callback.h>

#include <memory>

#include "fit/ceres_reference.h"
#include "fit/ceres_stop.h"

namespace dermap {
namespace {

constexpr int kMemory = 30;
constexpr double kFunctionTolerance = 1e-7, kGradientTolerance = 1e-12;

// position = start + sum over octaves of doubled details, spread * z.
class DetailFunction final : public ceres::FirstOrderFunction {
 public:
  DetailFunction(const Posterior& posterior, Posterior::Position start, const std::vector<FreeVector>& spread)
      : posterior_(posterior), start_(std::move(start)), spread_(spread) {
    for (const GridShape shape : posterior.shapes()) count_ += shape.size() * start_.size();
  }
  int NumParameters() const override { return static_cast<int>(count_); }

  Posterior::Position PositionOf(const double* z) const {
    const auto& shapes = posterior_.shapes();
    Posterior::Position position;
    const double* next = z + count_;  // octaves lie finest first
    for (std::size_t l = shapes.size(); l-- > 0;) {
      next -= shapes[l].size() * start_.size();
      for (std::size_t j = 0; j < start_.size(); ++j) {
        PlaneF detail = PlaneOf(next + j * shapes[l].size(), shapes[l], spread_[l][j]);
        if (l + 1 == shapes.size()) {
          position.push_back(std::move(detail));
          continue;
        }
        detail = DetailOf(detail);
        const PlaneF coarser = Double(position[j], shapes[l]);
        for (std::size_t i = 0; i < detail.size(); ++i) detail.data()[i] += coarser.data()[i];
        position[j] = std::move(detail);
      }
    }
    for (std::size_t j = 0; j < start_.size(); ++j)
      for (std::size_t i = 0; i < start_[j].size(); ++i) position[j].data()[i] += start_[j].data()[i];
    return position;
  }

  bool Evaluate(const double* z, double* cost, double* gradient) const override {
    const Posterior::Position position = PositionOf(z);
    ++evaluations_;
    if (!gradient) {
      *cost = posterior_.Value(position);
      return true;
    }
    Posterior::Position derivative;
    *cost = posterior_.ValueAndGradient(position, derivative);
    const auto& shapes = posterior_.shapes();
    for (std::size_t l = 0; l < shapes.size(); ++l) {
      const bool top = l + 1 == shapes.size();
      for (PlaneF& plane : derivative) {
        const std::size_t j = static_cast<std::size_t>(&plane - derivative.data());
        const PlaneF own = top ? plane : DetailTransposed(plane);
        for (std::size_t i = 0; i < own.size(); ++i) *gradient++ = own.data()[i] * spread_[l][j];
        if (!top) plane = DoubleTransposed(plane);
      }
    }
    return true;
  }

  int evaluations() const { return evaluations_; }

 private:
  static PlaneF PlaneOf(const double* z, GridShape shape, double factor) {
    PlaneF plane(shape.width, shape.height);
    for (std::size_t i = 0; i < plane.size(); ++i) plane.data()[i] = static_cast<float>(z[i] * factor);
    return plane;
  }

  const Posterior& posterior_;
  Posterior::Position start_;
  const std::vector<FreeVector>& spread_;
  std::size_t count_ = 0;
  mutable int evaluations_ = 0;
};

}  // namespace

ReferenceOutcome MinimiseByGradient(const Posterior& posterior, const ParameterMaps& start,
                                    const std::vector<FreeVector>& spread, int max_iterations, RunLog& log) {
  auto* function = new DetailFunction(posterior, posterior.PositionOf(start), spread);
  const ceres::GradientProblem problem(function);  // owns it
  std::vector<double> z(function->NumParameters(), 0.0);
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::LBFGS;
  options.max_lbfgs_rank = kMemory;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = kFunctionTolerance;
  options.gradient_tolerance = kGradientTolerance;
  options.parameter_tolerance = 0.0;
  options.logging_type = ceres::SILENT;
  const auto stop = StopWhenAsked(log);
  options.callbacks.push_back(stop.get());
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, z.data(), &summary);
  log.Progress(1.0);
  ReferenceOutcome outcome;
  outcome.maps = posterior.MapsOf(function->PositionOf(z.data()));
  outcome.converged = summary.termination_type == ceres::CONVERGENCE;
  outcome.objective = summary.final_cost;
  outcome.evaluations = function->evaluations();
  return outcome;
}

}  // namespace dermap
