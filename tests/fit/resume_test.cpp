// SPDX-License-Identifier: Apache-2.0
// Fits that are stopped on the way and go on.
#include "fit/resume.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "common/core/error.h"
#include "fit/fit.h"
#include "fit/write_fit.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

constexpr int kNever = std::numeric_limits<int>::max();

class Resume : public ::testing::Test {
 protected:
  Resume()
      : directory_(
            std::filesystem::path(::testing::TempDir()) /
            (std::string("resume_") + ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Window(7.5 / 40));
    stack_ = testing::NoisyStack(model, testing::SpottedSkin(40, 0.06), 0.005, 3);
    options_.free_parameters = testing::AllParameters();
  }
  ~Resume() override { std::filesystem::remove_all(directory_); }

  // Stopped once it has been asked `questions` times.
  FitResult FitUntil(int questions) {
    int asked = 0;
    options_.stop = [&] { return asked++ >= questions; };
    return FitStack(stack_, options_, testing::TestChromophores());
  }
  // The folder that `fit` becomes, read again.
  UnfinishedFit Kept(const FitResult& fit) {
    WriteFit(directory_, fit);
    return ReadUnfinishedFit(directory_);
  }

  std::filesystem::path directory_;
  ReflectanceStack stack_;
  FitOptions options_;
};

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

// rms of how far the maps of C_m are apart, in standard deviations.
double Apart(const FitResult& a, const FitResult& b) {
  double squares = 0.0;
  const PlaneF &one = a.maps[Parameter::kC_m], &other = b.maps[Parameter::kC_m];
  for (std::size_t i = 0; i < one.size(); ++i)
    squares += std::pow((one.data()[i] - other.data()[i]) / b.sigma[Parameter::kC_m].data()[i], 2);
  return std::sqrt(squares / static_cast<double>(one.size()));
}

// Descent goes on where it was: the misfit begins where it ended, and ends where an undisturbed fit ends.
TEST_F(Resume, DescentGoesOnWhereItStopped) {
  options_.method = FitMethod::kDescent;
  options_.stop_chi2 = 0.0;
  const FitResult whole = FitUntil(kNever), half = FitUntil(4);
  EXPECT_TRUE(whole.finished);
  EXPECT_FALSE(half.finished);
  EXPECT_FALSE(half.converged);
  EXPECT_EQ(half.history.size(), 5u);  // the start and four iterations
  options_.resume = Kept(half);
  const FitResult rest = FitUntil(kNever);
  EXPECT_TRUE(rest.finished);
  EXPECT_NEAR(rest.history.front().rms_residual, half.rms_residual, 1e-6);
  EXPECT_LT(rest.history.front().rms_residual, 0.5 * whole.history.front().rms_residual);
  EXPECT_NEAR(rest.chi2_per_datum, whole.chi2_per_datum, 0.05 * whole.chi2_per_datum);
}

// The fast fit ends at the same maps within a fraction of their error bars, whenever it was stopped; error
// bars are there even where it was stopped at once.
TEST_F(Resume, FastEndsWhereAnUndisturbedFitEnds) {
  const FitResult whole = FitUntil(kNever);
  for (const int questions : {0, 2, 3}) {
    options_.resume.reset();
    const FitResult part = FitUntil(questions);
    EXPECT_FALSE(part.finished) << questions;
    for (const float sigma : part.sigma[Parameter::kC_m].values()) EXPECT_GT(sigma, 0.0f);
    options_.resume = Kept(part);
    const FitResult rest = FitUntil(kNever);
    EXPECT_TRUE(rest.finished && rest.converged) << questions;
    EXPECT_LT(Apart(rest, whole), 0.3) << questions;
  }
}

TEST_F(Resume, RefusesOtherSettings) {
  options_.resume = Kept(FitUntil(1));
  options_.profiles = "multipole";
  EXPECT_THAT(MessageOf([&] { FitUntil(1); }), HasSubstr("profiles was 'exact', but is 'multipole' now"));
  options_.profiles = "exact";
  options_.tissue.n_dermis = 1.36;
  EXPECT_THAT(MessageOf([&] { FitUntil(1); }), HasSubstr("its tissue was"));
  options_.tissue = {};
  stack_.reflectance[3](2, 2) *= 1.01f;
  EXPECT_THAT(MessageOf([&] { FitUntil(1); }), HasSubstr("not those of this stack"));
}

}  // namespace
}  // namespace dermap
