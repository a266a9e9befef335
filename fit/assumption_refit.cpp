// SPDX-License-Identifier: Apache-2.0
// A parabola through refits.
#include "fit/assumption_refit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/assumption_products.h"
#include "fit/octave_solver.h"

namespace dermap {
namespace {

constexpr double kFirstStep = 0.15, kFurthest = 0.6;  // logarithm of true over told
// Of the error found, how uncertain it is: bounds hide a part of what the data say (a thickness told 1.1
// times the true one is found as 1.05).
constexpr double kUncertain = 0.5;
constexpr int kSteps = 8, kParabolas = 4;

// One refit: half of what the data say against it, if the patch's mean is as good as stated and if it is as
// bad as the fit found it; and its maps.
struct Trial {
  double error = 0.0, objective = 0.0, doubting_mean = 0.0;
  ParameterMaps maps;
};

class Refits {
 public:
  Refits(const std::vector<PlaneF>& answer, const PatchProblem& problem, const FitState& state,
         const DetailView& detail, const SkinPoint& fixed)
      : answer_(answer), problem_(problem), space_(WithoutJunction(problem.space())), fixed_(fixed) {
    start_ = state.maps;
    start_.junction_absorbance.clear();
    model_.prior.assign(detail.prior.begin(), detail.prior.end());
    model_.details.assign(detail.details.begin(), detail.details.end());
    model_.scatter.assign(detail.scatter.begin(), detail.scatter.end());
    model_.blur.assign(detail.blur.begin(), detail.blur.end());
    model_.activity.assign(detail.activity.begin(), detail.activity.end());
    KeepFree(problem.space(), space_, model_);
  }

  Trial At(double error, bool trust_mean) {
    FitData data = problem_.data();
    for (int b = 0; b < data.band_count(); ++b)
      for (std::size_t i = 0; i < answer_[b].size(); ++i) {
        const auto factor = static_cast<float>(std::exp(-error * answer_[b].data()[i]));
        data.measured[b].data()[i] *= factor;
        data.sigma[b].data()[i] *= factor;
      }
    PatchProblem problem(data, problem_.model(), space_);
    DetailModel model = model_, trusting = model_;
    trusting.scatter.back() = 1.0;
    const DetailView detail = ViewFrom(model, 0);
    FitState state = problem.StateOf(start_);
    for (int step = 0; step < kSteps; ++step) {
      model.scatter = trust_mean ? trusting.scatter : model_.scatter;
      const OctaveStep taken = SolveInOctaves(problem, LineariseInOctaves(problem, state), detail, fixed_);
      Update(taken.statistics, space_.count(), detail);
      state = problem.StateOf(Apply(problem, state.maps, taken));
    }
    const std::vector<OctaveLevel> levels = LineariseInOctaves(problem, state);
    const Answered left{levels[0].residual, {}};
    const auto half = [&](DetailModel& of) {
      return 0.5 * Product(levels, problem_.space(), ViewFrom(of, 0), left, left);
    };
    return {error, half(trusting), half(model_), std::move(state.maps)};
  }

 private:
  static ParameterSpace WithoutJunction(const ParameterSpace& space) {
    std::vector<Parameter> free = space.free();
    std::erase(free, Parameter::kJunctionAbsorbance);
    return ParameterSpace(free);
  }

  const std::vector<PlaneF>& answer_;
  const PatchProblem& problem_;
  ParameterSpace space_;
  SkinPoint fixed_;
  ParameterMaps start_;
  DetailModel model_;
};

struct Parabola {
  double vertex = 0.0, curvature = 0.0;
};

Parabola Through(const std::vector<Trial>& t) {
  const double left = (t[1].objective - t[0].objective) / (t[1].error - t[0].error);
  const double right = (t[2].objective - t[1].objective) / (t[2].error - t[1].error);
  const double curvature = 2.0 * (right - left) / (t[2].error - t[0].error);
  return {0.5 * (t[0].error + t[1].error) - left / curvature, curvature};
}

}  // namespace

void RefitUnder(const std::vector<PlaneF>& answer, const PatchProblem& problem, const FitState& state,
                const DetailView& detail, const SkinPoint& fixed, double test_error, AssumptionCheck& check) {
  if (detail.link) return;
  Refits refits(answer, problem, state, detail, fixed);
  std::vector<Trial> trials;  // the best and its neighbours, by error
  for (const double error : {-kFirstStep, 0.0, kFirstStep}) trials.push_back(refits.At(error, true));
  const double told = refits.At(0.0, false).doubting_mean;
  Parabola parabola = Through(trials);
  for (int again = 0; again < kParabolas && parabola.curvature > 0.0; ++again) {
    trials.push_back(refits.At(std::clamp(parabola.vertex, -kFurthest, kFurthest), true));
    std::sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.error < b.error; });
    const auto best =
        std::min_element(trials.begin(), trials.end(),
                         [](const Trial& a, const Trial& b) { return a.objective < b.objective; }) -
        trials.begin();
    // The one that is farther from the best of those at the ends.
    trials.erase(best >= 2 ? trials.begin() : trials.end() - 1);
    parabola = Through(trials);
  }
  if (!(parabola.curvature > 0.0)) return;
  Trial& best = *std::min_element(trials.begin(), trials.end(),
                                  [](const Trial& a, const Trial& b) { return a.objective < b.objective; });
  const double sigma = std::sqrt(1.0 / (parabola.curvature + 1.0 / (kExpectedError * kExpectedError)));
  check.log_error = best.error;
  check.log_evidence = told - best.doubting_mean - std::log(kExpectedError / sigma);
  check.log_evidence_seen = check.log_evidence;
  check.sigma = std::hypot(sigma, test_error, kUncertain * check.log_error);
  const ParameterSpace& space = problem.space();
  for (int j = 0; j < space.count(); ++j) {
    const Parameter p = space.parameter(j);
    PlaneF& plane = check.maps.emplace_back(
        p == Parameter::kJunctionAbsorbance
            ? PlaneF(state.maps.width(), state.maps.height(), static_cast<float>(fixed[kParameterCount]))
            : best.maps.Unknown(p));
    for (float& value : plane.values()) value = static_cast<float>(value / space.scale(j));
  }
}

}  // namespace dermap
