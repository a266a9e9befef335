// SPDX-License-Identifier: Apache-2.0
// Simultaneous descent on small patches. Scene and fit share the forward model: the optimiser is on trial,
// not the physics.
#include "fit/descent.h"

#include <gtest/gtest.h>

#include "fit/local_start.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

struct Trial {
  DescentOutcome outcome;
  RunLog log;
};

Trial DescendFrom(PatchProblem& problem, ParameterMaps start, const FitOptions& options) {
  Trial run;
  run.outcome = Descend(problem, std::move(start), options, run.log);
  return run;
}

void ExpectWithinBounds(const ParameterMaps& maps) {
  for (int i = 0; i < kParameterCount; ++i) {
    for (float value : maps.planes[i].values()) {
      ASSERT_GE(value, kParameters[i].lower);
      ASSERT_LE(value, static_cast<float>(kParameters[i].upper));
    }
  }
}

class DescentTest : public ::testing::Test {
 protected:
  DescentTest()
      : model_(testing::MakeModel(testing::EightBands(), testing::Window(7.5 / 16))),
        truth_(testing::SpottedSkin(16, 0.05)),
        stack_(testing::NoisyStack(model_, truth_, 0.005, 5)),
        data_(testing::Prepared(stack_)),
        problem_(data_, model_, ParameterSpace(testing::AllParameters())) {}

  ForwardModel model_;
  ParameterMaps truth_;
  ReflectanceStack stack_;
  FitData data_;
  PatchProblem problem_;
  FitOptions options_;
};

// The noise that was added is the level that a fit can reach: chi2 per degree about 1 [D08 6.4: the remaining
// mismatch is noise], from average skin as in [D08 6.3] and from the closed-form start.
TEST_F(DescentTest, ReachesTheNoiseFromBothStarts) {
  for (bool local : {false, true}) {
    ParameterMaps start =
        local ? InvertLocally(problem_, AverageSkin()) : ParameterMaps(16, 16, AverageSkin());
    const Trial run = DescendFrom(problem_, std::move(start), options_);
    EXPECT_TRUE(run.outcome.converged);
    EXPECT_LT(run.outcome.state.misfit.Chi2PerDegree(5), 1.3);
    EXPECT_LT(testing::MedianRelativeError(run.outcome.state.maps[Parameter::kC_m], truth_[Parameter::kC_m]),
              0.06);
    ExpectWithinBounds(run.outcome.state.maps);
  }
}

// By construction (a step that lowers nothing is taken back): the misfit of the whole never rises, for either
// metric.
TEST_F(DescentTest, MisfitNeverRises) {
  options_.max_iterations = 12;
  for (DescentMetric metric : {DescentMetric::kPlain, DescentMetric::kCurvature}) {
    options_.metric = metric;
    const Trial run = DescendFrom(problem_, ParameterMaps(16, 16, AverageSkin()), options_);
    ASSERT_GE(run.log.history.size(), 3u);
    for (std::size_t i = 1; i < run.log.history.size(); ++i)
      EXPECT_LE(run.log.history[i].chi2, run.log.history[i - 1].chi2);
    EXPECT_LT(run.log.history.back().chi2, 0.2 * run.log.history.front().chi2);
  }
}

// Out of iterations is a result, with the record of how far it came; each iteration costs a render for every
// free parameter and one or two more [D08 6.3].
TEST_F(DescentTest, StopsUnconvergedWithoutAnException) {
  options_.max_iterations = 2;
  const Trial run = DescendFrom(problem_, ParameterMaps(16, 16, AverageSkin()), options_);
  EXPECT_FALSE(run.outcome.converged);
  EXPECT_EQ(run.log.history.size(), 3u);
  EXPECT_GE(problem_.renders(), 1 + 2 * 6);
  EXPECT_LE(problem_.renders(), 1 + 2 * 7);
}

// Pixels do not couple under uniform skin and light: there each pixel's own chi2 must fall from step to step.
TEST(Descent, EveryPixelGainsOnUniformSkin) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.3));
  const ParameterVector truth{0.1, 0.62, 0.005, 0.01, 0.05};
  const FitData data = testing::Prepared(testing::NoisyStack(model, ParameterMaps(6, 6, truth), 1e-4, 2), 2);
  PatchProblem problem(data, model, ParameterSpace({Parameter::kC_m, Parameter::kC_hd}));
  FitOptions options;
  options.max_iterations = 1;
  for (DescentMetric metric : {DescentMetric::kPlain, DescentMetric::kCurvature}) {
    options.metric = metric;
    FitState state = problem.StateOf(ParameterMaps(6, 6, AverageSkin()));
    for (int iteration = 0; iteration < 3; ++iteration) {
      const Plane<double> before = state.misfit.chi2_map;
      state = DescendFrom(problem, state.maps, options).outcome.state;
      for (std::size_t i = 0; i < before.size(); ++i)
        ASSERT_LE(state.misfit.chi2_map.data()[i], before.data()[i]) << "iteration " << iteration;
    }
  }
}

// Skin darker in melanin than table 1 allows ends on the bound.
TEST(Descent, EndsOnABoundWhereTheDataLieBeyond) {
  const ForwardModel model = testing::MakeModel(testing::FourBands(), testing::Uniform(0.3));
  ParameterVector dark = AverageSkin();
  dark[0] = 0.7;
  const FitData data = testing::Prepared(testing::NoisyStack(model, ParameterMaps(4, 4, dark), 0.001, 2), 1);
  PatchProblem problem(data, model, ParameterSpace({Parameter::kC_m}));
  const Trial run = DescendFrom(problem, ParameterMaps(4, 4, AverageSkin()), FitOptions{});
  for (float value : run.outcome.state.maps[Parameter::kC_m].values()) EXPECT_FLOAT_EQ(value, 0.5f);
}

}  // namespace
}  // namespace dermap
