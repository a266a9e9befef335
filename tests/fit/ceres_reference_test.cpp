// SPDX-License-Identifier: Apache-2.0
// The objective, its gradient, and the reference solvers that the fast fit is held against.
#include "fit/ceres_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "fit/fast.h"
#include "fit/local_start.h"
#include "fit/octave_solver.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

using testing::AllParameters;

// A patch of large pixels, fitted fast.
struct Patch {
  explicit Patch(int size)
      : model(ModelOf(testing::Window(7.5 / size))),
        data(
            Exact(testing::Prepared(testing::NoisyStack(model, testing::SpottedSkin(size, 0.05), 0.005, 5)))),
        fast(FitCoarseToFine(data, model, AllParameters(), maker, options, log)),
        problem(data, model, ParameterSpace(AllParameters())),
        detail(ViewFrom(fast.detail, 0)),
        posterior(problem, detail, fast.fixed) {}

  // Scene and fit share the model.
  static FitData Exact(FitData data) {
    data.shared_error = 0.0;
    return data;
  }
  static ForwardModel ModelOf(const ImagingConditions& conditions) {
    const ForwardModel exact = testing::MakeModel(testing::EightBands(), conditions);
    ForwardOptions options = exact.options();
    options.tolerance = 1e-3;
    return exact.With(options);
  }
  const ModelMaker maker = ModelOf;
  FitOptions options;
  RunLog log;
  ForwardModel model;
  FitData data;
  FastOutcome fast;
  PatchProblem problem;
  DetailView detail;
  Posterior posterior;
};

// Against differences of the value along random directions. Planes are floats, so a difference of values of
// some hundred is good to about 1e-3.
TEST(Posterior, GradientIsTheDifference) {
  Patch patch(12);
  Posterior::Position at = patch.posterior.PositionOf(patch.fast.state.maps), gradient;
  for (PlaneF& plane : at)
    for (float& value : plane.values()) value *= 1.02f;  // off the minimum
  patch.posterior.ValueAndGradient(at, gradient);
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (int direction = 0; direction < 3; ++direction) {
    Posterior::Position up = at, down = at;
    double expected = 0.0;
    for (std::size_t j = 0; j < at.size(); ++j) {
      const float length = 1e-3f * std::sqrt(patch.fast.variance[j](6, 6) / patch.fast.variance[0](6, 6));
      for (std::size_t i = 0; i < at[j].size(); ++i) {
        const float step = length * normal(random);
        up[j].data()[i] += step;
        down[j].data()[i] -= step;
        expected += 2.0 * step * gradient[j].data()[i];
      }
    }
    const double difference = patch.posterior.Value(up) - patch.posterior.Value(down);
    EXPECT_NEAR(difference, expected, 0.02 * std::abs(expected) + 0.02);
  }
}

// Levenberg-Marquardt from the local inversion finds the minimum that the fast fit approaches: no objective
// is lower, and the fast fit's is within a few per cent of the data (its steps take each octave's blur as a
// factor). Its covariance, from the exact Jacobian of all pixels by all parameters, judges the error bars
// that the fast fit has without any matrix; of noise that is large against what the bands' means share, and
// for a prior that is taken as known, as the reference has it.
TEST(CeresReference, DenseJudgesFast) {
  Patch patch(8);
  std::fill(patch.fast.detail.scatter.begin(), patch.fast.detail.scatter.end(), 1.0);
  std::fill(patch.fast.detail.details.begin(), patch.fast.detail.details.end(), FreeVector{});
  const FitState state = patch.problem.StateOf(patch.fast.state.maps);
  const OctaveStep fast_step =
      SolveInOctaves(patch.problem, LineariseInOctaves(patch.problem, state), patch.detail, patch.fast.fixed);
  const ReferenceOutcome reference = MinimiseDense(
      patch.posterior, patch.detail, InvertLocally(patch.problem, AverageSkin()), 30, patch.log);
  EXPECT_TRUE(reference.converged);
  const double fast = patch.posterior.Value(patch.posterior.PositionOf(patch.fast.state.maps));
  EXPECT_LE(reference.objective, fast * 1.0001);
  EXPECT_LT(fast, reference.objective * 1.15);
  const ParameterSpace& space = patch.problem.space();
  for (int j = 0; j < space.count(); ++j) {
    double log_ratio = 0.0, square = 0.0;
    const PlaneF& found = patch.fast.state.maps.Unknown(space.parameter(j));
    for (std::size_t i = 0; i < found.size(); ++i) {
      log_ratio += 0.5 * std::log(fast_step.variance[j].data()[i] / reference.variance[j].data()[i]);
      const double apart = (found.data()[i] - reference.maps.Unknown(space.parameter(j)).data()[i]) /
                           space.scale(j) / std::sqrt(reference.variance[j].data()[i]);
      square += apart * apart;
    }
    const double pixels = static_cast<double>(found.size());
    EXPECT_NEAR(std::exp(log_ratio / pixels), 1.0, 0.2) << InfoOf(space.parameter(j)).name;
    EXPECT_LT(std::sqrt(square / pixels), 0.7) << InfoOf(space.parameter(j)).name;
  }
}

// Gradients alone lower the objective of the fast fit's maps.
TEST(CeresReference, GradientsLowerTheObjective) {
  Patch patch(24);
  const double fast = patch.posterior.Value(patch.posterior.PositionOf(patch.fast.state.maps));
  const ReferenceOutcome reference =
      MinimiseByGradient(patch.posterior, patch.fast.state.maps, patch.fast.spread, 40, patch.log);
  EXPECT_LT(reference.objective, fast);
  EXPECT_GT(reference.objective, 0.7 * fast);
}

}  // namespace
}  // namespace dermap
