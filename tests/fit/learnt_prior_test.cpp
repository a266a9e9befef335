// SPDX-License-Identifier: Apache-2.0
// The prior that fits of eight bands teach, and what it is worth to an image of three wide ones. Scene and
// fit share the physics (the three bands' scenes are rendered over their whole filters, which the fit
// shortens), so what is on trial is the statistics.
#include "fit/learnt_prior.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "common/core/error.h"
#include "fit/fit.h"
#include "tests/fit/scene.h"

namespace dermap {
namespace {

using ::testing::AllOf;
using testing::AllParameters;
using ::testing::HasSubstr;

constexpr int kSize = 32;

// One person's patch: means drawn from a population, in which blood of both layers goes together, freckles
// and a vein that the eye sees, and smooth variation.
ParameterMaps Person(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.15, 0.85);
  const double melanin = 0.05 * std::exp(0.35 * normal(random)), flush = normal(random);
  const double eumelanin = 0.66 + 0.05 * normal(random), carotene = 0.012 + 0.002 * normal(random);
  const double above = 0.005 * std::exp(0.2 * flush + 0.1 * normal(random));
  const double below = 0.03 * std::exp(0.2 * flush + 0.1 * normal(random));
  const double x0 = uniform(random), y0 = uniform(random), slope = 0.5 * normal(random);
  const double freckle = 0.04 * std::abs(normal(random)), vein = 0.015 * std::abs(normal(random));
  const double phase = 3.0 * normal(random);
  ParameterMaps maps(kSize, kSize, AverageSkin());
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double u = (x + 0.5) / kSize, v = (y + 0.5) / kSize;
      const double spot = std::exp(-std::pow(std::hypot(u - x0, v - y0) / 0.12, 2));
      const double vessel = std::exp(-std::pow((v - 0.5 - slope * (u - 0.5)) / 0.1, 2));
      const auto set = [&](Parameter p, double value) { maps[p](x, y) = static_cast<float>(value); };
      set(Parameter::kC_m, melanin * (1.0 + 0.1 * std::sin(5.0 * u + phase)) + freckle * spot);
      set(Parameter::kBeta_m, eumelanin + 0.02 * std::sin(4.0 * v + phase) - 2.0 * freckle * spot);
      set(Parameter::kC_he, above * (1.0 + 0.15 * std::cos(5.0 * v - phase)));
      set(Parameter::kC_bc, carotene * (1.0 + 0.1 * std::cos(4.0 * u)));
      set(Parameter::kC_hd, below * (1.0 + 0.1 * std::sin(3.0 * u + 4.0 * v)) + vein * vessel);
    }
  return maps;
}

// A camera's three channels behind a calibration: blue, green and red, some 80 nm wide.
std::vector<Band> Rgb() {
  return {{460, 70}, {535, 80}, {605, 70}};
}

ForwardModel WholeFilters(const std::vector<Band>& bands) {
  const auto source = MakeProfileSource("exact");
  ForwardOptions options;
  options.full_band_integration = true;
  return ForwardModel(testing::TestChromophores(), *source, TissueConfig{}, bands,
                      testing::Window(7.5 / kSize), options);
}

FitResult Fit(const ReflectanceStack& stack, const std::optional<LearntPrior>& prior = {}) {
  FitOptions options;
  options.prior = prior;
  return FitStack(stack, options, testing::TestChromophores());
}

// Learnt from twelve people in eight bands of 0.5 % noise.
const LearntPrior& Learnt() {
  static const LearntPrior prior = [] {
    const ForwardModel model = testing::MakeModel(testing::EightBands(), testing::Window(7.5 / kSize));
    std::mt19937_64 random(11);
    std::optional<LearntPrior> sum;
    for (int person = 0; person < 12; ++person) {
      const FitResult fit = Fit(testing::NoisyStack(model, Person(random), 0.005, 100 + person));
      const LearntPrior own = LearnFrom(fit, "person " + std::to_string(person));
      sum = sum ? Combined(*sum, own) : own;
    }
    return *sum;
  }();
  return prior;
}

// Over all people's pixels, in the parameter's unit.
struct Errors {
  ParameterVector squares{}, scaled_squares{}, within_2{};
  int people = 0;

  void Add(const FitResult& fit, const ParameterMaps& truth) {
    ++people;
    for (int j = 0; j < kParameterCount; ++j) {
      const double share = 1.0 / static_cast<double>(truth.planes[j].size());
      for (std::size_t i = 0; i < truth.planes[j].size(); ++i) {
        const double error = fit.maps.planes[j].data()[i] - truth.planes[j].data()[i];
        squares[j] += share * error * error;
        const double sigma = fit.sigma.planes[j].data()[i];
        if (sigma <= 0.0) continue;
        scaled_squares[j] += share * error * error / (sigma * sigma);
        within_2[j] += share * (std::abs(error) < 1.96 * sigma);
      }
    }
  }
  double Rms(Parameter p) const { return std::sqrt(squares[static_cast<int>(p)] / people); }
  double Spread(Parameter p) const { return std::sqrt(scaled_squares[static_cast<int>(p)] / people); }
  double Within2(Parameter p) const { return within_2[static_cast<int>(p)] / people; }
};

// Eight people that were not learnt from. Without a prior three bands are fitted with what the evidence
// picks, the rest at average skin's values. Beside them the same people in eight bands, and the learnt mean
// alone.
TEST(LearntPrior, TellsThreeBandsWhatTheyCannotTell) {
  const ForwardModel model = WholeFilters(Rgb());
  std::mt19937_64 random(77);
  Errors with, without, eight, mean_alone;
  const ForwardModel narrow = testing::MakeModel(testing::EightBands(), testing::Window(7.5 / kSize));
  FitResult mean;
  mean.maps = ParameterMaps(kSize, kSize, Learnt().mean);
  mean.sigma = ParameterMaps(kSize, kSize, ParameterVector{});
  for (int person = 0; person < 8; ++person) {
    const ParameterMaps truth = Person(random);
    const ReflectanceStack stack = testing::NoisyStack(model, truth, 0.01, 200 + person);
    const FitResult fit = Fit(stack, Learnt());
    EXPECT_TRUE(fit.converged) << "person " << person;
    EXPECT_EQ(fit.free_parameters, AllParameters());
    EXPECT_LT(fit.chi2, 1.3) << "person " << person;
    with.Add(fit, truth);
    without.Add(Fit(stack), truth);
    eight.Add(Fit(testing::NoisyStack(narrow, truth, 0.005, 300 + person)), truth);
    mean_alone.Add(mean, truth);
  }
  for (const Parameter p : AllParameters()) {
    const auto name = InfoOf(p).name;
    std::printf(
        "%-7s rms error: mean alone %.5f, RGB without prior %.5f, with %.5f (spread %.2f, 95 %%: %.2f), "
        "eight bands %.5f\n",
        name.data(), mean_alone.Rms(p), without.Rms(p), with.Rms(p), with.Spread(p), with.Within2(p),
        eight.Rms(p));
    EXPECT_LT(eight.Rms(p), with.Rms(p)) << name;
    EXPECT_LT(with.Rms(p), 0.8 * without.Rms(p)) << name;
    // Errors of a patch hang together: eight people are some eight independent ones.
    EXPECT_GT(with.Spread(p), 0.4) << name;
    EXPECT_LT(with.Spread(p), 1.6) << name;
    EXPECT_GT(with.Within2(p), 0.8) << name;
  }
  EXPECT_LT(with.Rms(Parameter::kC_m), 0.3 * mean_alone.Rms(Parameter::kC_m));
  EXPECT_LT(with.Rms(Parameter::kC_hd), mean_alone.Rms(Parameter::kC_hd));
}

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

// A prior of known moments: `count` patches of one pixel's detail.
LearntPrior Made(double melanin, const std::string& name) {
  LearntPrior prior;
  prior.sources = {{name, name}};
  prior.mean = AverageSkin();
  prior.mean[0] = melanin;
  for (int j = 0; j < kParameterCount; ++j) prior.detail_covariance[j][j] = 1e-4 * (j + 1);
  return prior;
}

// Means 1, 2 and 6 hundredths: mean 3, sum of squares (4 + 1 + 9) / 3.
TEST(LearntPrior, CombinesAsIfLearntTogether) {
  const LearntPrior all = Combined(Combined(Made(0.01, "a"), Made(0.02, "b")), Made(0.06, "c"));
  EXPECT_EQ(all.fits(), 3);
  EXPECT_NEAR(all.mean[0], 0.03, 1e-15);
  EXPECT_NEAR(all.covariance[0][0], 14e-4 / 3.0, 1e-15);
  EXPECT_NEAR(all.covariance[1][1], 0.0, 1e-15);
  EXPECT_NEAR(all.detail_covariance[2][2], 3e-4, 1e-15);
}

TEST(LearntPrior, CountsAPatchOnce) {
  EXPECT_THAT(MessageOf([] { Combined(Made(0.01, "a"), Made(0.02, "a")); }),
              HasSubstr("already holds the patch of a"));
}

// One fit says little: its covariance is the range's, 1 in scaled units. Many fits are believed: a thousand
// of a spread of 0.01 leave that.
TEST(LearntPrior, BelievesManyFitsMoreThanOne) {
  const ParameterSpace space({Parameter::kC_m});
  LearntPrior prior = Made(0.05, "a");
  EXPECT_NEAR(1.0 / LinkTo(prior, space).mean_precision[0][0], 1.0, 1e-12);
  prior.sources.resize(1000);
  prior.covariance[0][0] = 1e-4;
  const double spread = std::sqrt(1.0 / LinkTo(prior, space).mean_precision[0][0]) * space.scale(0);
  EXPECT_NEAR(spread, 0.0110, 1e-4);  // 1.001e-4 + (0.5^2 / 12) / 1000
  EXPECT_NEAR(LinkTo(prior, space).mean[0] * space.scale(0), 0.05, 1e-12);
}

// What is not free is integrated out: the covariance of what is free is that part of the whole's, whose
// inverse is not that part of the inverse.
TEST(LearntPrior, IntegratesOutWhatIsNotFree) {
  LearntPrior prior = Made(0.05, "a");
  prior.sources.resize(500);
  prior.covariance = {{{1e-4, 9e-4, 0, 0, 0}, {9e-4, 1e-2, 0, 0, 0}}};
  const ParameterSpace both({Parameter::kC_m, Parameter::kBeta_m}), one({Parameter::kC_m});
  const LinkedPrior two = LinkTo(prior, both);
  const FreeMatrix& p = two.mean_precision;
  const double variance = p[1][1] / (p[0][0] * p[1][1] - p[0][1] * p[1][0]);
  EXPECT_NEAR(1.0 / LinkTo(prior, one).mean_precision[0][0], variance, 1e-12);
  EXPECT_GT(p[0][0], 1.2 * LinkTo(prior, one).mean_precision[0][0]);
}

class LearntPriorFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ =
        std::filesystem::path(::testing::TempDir()) /
        (std::string("prior_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".json");
    prior_ = Combined(Made(0.01, "a"), Made(0.02, "b"));
    WriteLearntPrior(path_, prior_);
    std::ifstream file(path_);
    text_.assign(std::istreambuf_iterator<char>(file), {});
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string AfterEdit(const std::string& from, const std::string& to) {
    std::string text = text_;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(path_) << text;
    return MessageOf([&] { ReadLearntPrior(path_); });
  }

  std::filesystem::path path_;
  LearntPrior prior_;
  std::string text_;
};

TEST_F(LearntPriorFile, RoundTrips) {
  const LearntPrior read = ReadLearntPrior(path_);
  EXPECT_EQ(read.fits(), 2);
  EXPECT_EQ(read.sources[1].name, "b");
  EXPECT_EQ(read.mean, prior_.mean);
  EXPECT_EQ(read.covariance, prior_.covariance);
  EXPECT_EQ(read.detail_covariance, prior_.detail_covariance);
}

TEST_F(LearntPriorFile, SaysWhatIsWrong) {
  const std::string name = path_.filename().string();
  EXPECT_THAT(MessageOf([&] { ReadLearntPrior(path_.string() + ".none"); }), HasSubstr(".none"));
  EXPECT_THAT(AfterEdit("dermap prior", "other"), AllOf(HasSubstr(name), HasSubstr("not a prior")));
  EXPECT_THAT(AfterEdit("\"format_version\": 1", "\"format_version\": 2"), HasSubstr("version 2"));
  EXPECT_THAT(AfterEdit("\"fits\": 2", "\"fits\": 3"), HasSubstr("counts 3 fits, but lists 2"));
  EXPECT_THAT(AfterEdit("\"C_m\": 0.015", "\"C_m\": NaN"), HasSubstr("not valid JSON"));
  EXPECT_THAT(AfterEdit("\"C_m\": 0.015", "\"C_m\": null"), HasSubstr("C_m"));
  EXPECT_THAT(AfterEdit("\"C_m\": 0.015", "\"C_m\": 15"), HasSubstr("C_m"));
  EXPECT_THAT(AfterEdit("\"C_m\": 0.015", "\"melanin\": 0.015"), HasSubstr("C_m"));
  EXPECT_THAT(AfterEdit("\"covariance\"", "\"covariances\""), HasSubstr("covariance"));
  EXPECT_THAT(AfterEdit("      0.0001,", "      -0.0001,"), HasSubstr("not positive definite"));
  EXPECT_THAT(AfterEdit("      0.0001,\n      0.0,", "      0.0001,\n      0.5,"),
              HasSubstr("not symmetric"));
  EXPECT_THAT(AfterEdit("      0.0001,\n      0.0,", "      0.0001,"), HasSubstr("has 4 numbers"));
  std::ofstream(path_) << text_.substr(0, text_.size() / 2);
  EXPECT_THAT(MessageOf([&] { ReadLearntPrior(path_); }), HasSubstr("not valid JSON"));
}

// Methods that know no prior, and fits that teach nothing.
TEST(LearntPrior, RefusesWhatItCannotServe) {
  ReflectanceStack stack;
  FitOptions options;
  options.prior = Made(0.05, "a");
  options.method = FitMethod::kDescent;
  EXPECT_THAT(MessageOf([&] { FitStack(stack, options, testing::TestChromophores()); }),
              HasSubstr("descent knows no prior"));
  FitResult fit;
  fit.converged = true;
  fit.bands = Rgb();
  EXPECT_THAT(MessageOf([&] { LearnFrom(fit, "x.exr"); }), AllOf(HasSubstr("x.exr"), HasSubstr("3 bands")));
  fit.bands = testing::EightBands();
  fit.method = "descent";
  EXPECT_THAT(MessageOf([&] { LearnFrom(fit, "x.exr"); }), HasSubstr("descent"));
  fit.method = "fast";
  fit.converged = false;
  EXPECT_THAT(MessageOf([&] { LearnFrom(fit, "x.exr"); }), HasSubstr("did not converge"));
}

}  // namespace
}  // namespace dermap
