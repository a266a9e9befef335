// SPDX-License-Identifier: Apache-2.0
// Score tests.
#include "fit/assumptions.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/optics/homogeneous_skin.h"
#include "fit/assumption_products.h"
#include "fit/assumption_refit.h"
#include "fit/octave_solver.h"

namespace dermap {
namespace {

constexpr double kPixelStep = 0.2, kThicknessStep = 0.05;  // of the differences, logarithms
constexpr double kSmallPixelStep = -1.4;               // where pixels are told so large that no blur is seen
constexpr double kAtBound = 1e-4, kMostAtBound = 0.1;  // of the range; of the pixels
constexpr float kProbe = 1e-3f;  // of an answer, so that no bound of a parameter is near
constexpr double kAboveTolerance = 5.0;
constexpr double kClamped = 1e-12;  // variance of what may not move, scaled units
constexpr float kDarkest = 1e-7f;
constexpr int kMakeUpSteps = 2;

// Mean over the fitted pixels.
SkinPoint MeanSkin(const PatchProblem& problem, const ParameterMaps& maps) {
  SkinPoint mean{};
  double count = 0.0;
  for (std::size_t i = 0; i < problem.data().fitted.size(); ++i) {
    if (!problem.data().fitted.data()[i]) continue;
    const SkinPoint p = problem.PointAt(maps, i);
    for (int k = 0; k < kUnknownCount; ++k) mean[k] += p[k];
    count += 1.0;
  }
  for (double& value : mean) value /= count;
  return mean;
}

// A difference of renders below their tolerance says nothing.
bool IsSeen(const PatchProblem& problem, const std::vector<PlaneF>& answer, double step) {
  double squares = 0.0, count = 0.0;
  for (const PlaneF& plane : answer) {
    for (const float value : plane.values()) squares += static_cast<double>(value) * value;
    count += static_cast<double>(plane.size());
  }
  return std::abs(step) * std::sqrt(squares / count) > kAboveTolerance * problem.model().options().tolerance;
}

std::vector<PlaneF> AnswerToStep(const PatchProblem& problem, const FitState& state, double step) {
  ImagingConditions other = problem.model().conditions();
  other.pixel_size_mm *= std::exp(step);
  std::vector<PlaneF> answer = problem.model().With(other).Render(state.maps);
  for (std::size_t b = 0; b < answer.size(); ++b)
    for (std::size_t i = 0; i < answer[b].size(); ++i)
      answer[b].data()[i] =
          static_cast<float>(std::log(std::max<double>(answer[b].data()[i], kDarkest) /
                                      std::max<double>(state.predicted[b].data()[i], kDarkest)) /
                             step);
  return answer;
}

// Pixels at a bound answer no more: with many of them the optimum is not where the score of maps is nothing.
bool IsBounded(const PatchProblem& problem, const std::vector<OctaveLevel>& levels) {
  const ParameterSpace& space = problem.space();
  for (int j = 0; j < space.count(); ++j) {
    const PlaneF& position = levels[0].position[j];
    const double near = kAtBound * (space.upper()[j] - space.lower()[j]);
    const auto at_bound = std::count_if(position.values().begin(), position.values().end(), [&](float value) {
      return value < space.lower()[j] + near || value > space.upper()[j] - near;
    });
    if (static_cast<double>(at_bound) > kMostAtBound * static_cast<double>(position.size())) return true;
  }
  return false;
}

// The details of a position in the maps, octave by octave.
void SetDetails(const std::vector<PlaneF>& position, std::vector<OctaveLevel>& levels) {
  for (std::size_t j = 0; j < position.size(); ++j) {
    PlaneF plane = position[j];
    for (OctaveLevel& level : levels) {
      const bool top = &level == &levels.back();
      level.detail[j] = top ? plane : DetailOf(plane);
      if (!top) plane = Halve(plane);
    }
  }
}

// The engine `lowrank` has by far the cheapest tangent.
std::optional<ForwardModel> WithTangent(const ForwardModel& model) {
  ForwardOptions options = model.options();
  if (options.engine == Engine::kLowRank) return std::nullopt;
  options.engine = Engine::kLowRank;
  return model.With(options);
}

// What a small change of the maps does to the logarithm of reflectance.
std::vector<PlaneF> Response(const PatchProblem& problem, const FitState& state,
                             const ForwardModel::Kept& render, const std::vector<PlaneF>& change) {
  const ParameterSpace& space = problem.space();
  ParameterMaps maps;
  for (int j = 0; j < space.count(); ++j) {
    PlaneF plane = change[j];
    for (float& value : plane.values()) value *= static_cast<float>(space.scale(j));
    if (space.parameter(j) == Parameter::kJunctionAbsorbance)
      maps.junction_absorbance = {std::move(plane)};
    else
      maps[space.parameter(j)] = std::move(plane);
  }
  std::vector<PlaneF> response = render.Tangent(maps);
  for (std::size_t b = 0; b < response.size(); ++b)
    for (std::size_t i = 0; i < response[b].size(); ++i)
      response[b].data()[i] /= std::max(state.predicted[b].data()[i], kDarkest);
  return response;
}

// The maps that make up for `answer` as far as they can, by steps with the octaves' Jacobian, each against
// what the full one leaves.
Answered MakeUp(const PatchProblem& problem, const FitState& state, const ForwardModel::Kept& render,
                const std::vector<PlaneF>& answer, std::vector<OctaveLevel> levels, const DetailView& detail,
                const SkinPoint& fixed) {
  const auto count = static_cast<std::size_t>(problem.space().count());
  const PlaneF zero(state.maps.width(), state.maps.height());
  Answered made_up{answer, std::vector<PlaneF>(count, zero)};
  for (int step = 0; step < kMakeUpSteps; ++step) {
    for (std::size_t b = 0; b < answer.size(); ++b)
      for (std::size_t i = 0; i < zero.size(); ++i)
        levels[0].residual[b].data()[i] = kProbe * made_up.left[b].data()[i];
    CoarsenResiduals(levels);
    std::vector<PlaneF> position = made_up.distance;
    for (PlaneF& plane : position)
      for (float& value : plane.values()) value *= kProbe;
    SetDetails(position, levels);
    const OctaveStep solved = SolveInOctaves(problem, levels, detail, fixed);
    for (std::size_t j = 0; j < count; ++j)
      for (std::size_t i = 0; i < zero.size(); ++i)
        made_up.distance[j].data()[i] += solved.change[j].data()[i] / kProbe;
    const std::vector<PlaneF> response = Response(problem, state, render, made_up.distance);
    for (std::size_t b = 0; b < answer.size(); ++b)
      for (std::size_t i = 0; i < zero.size(); ++i)
        made_up.left[b].data()[i] = answer[b].data()[i] - response[b].data()[i];
  }
  return made_up;
}

// The data at the optimum of the maps, or at the one without the junction, to a step's exactness.
Answered DataAt(const PatchProblem& problem, const FitState& state, const ForwardModel::Kept& render,
                const std::vector<OctaveLevel>& levels, const DetailView& detail, const SkinPoint& fixed) {
  const OctaveStep step = SolveInOctaves(problem, levels, detail, fixed);
  const std::vector<PlaneF> response = Response(problem, state, render, step.change);
  Answered data{levels[0].residual, levels[0].position};
  for (std::size_t b = 0; b < response.size(); ++b)
    for (std::size_t i = 0; i < response[b].size(); ++i) data.left[b].data()[i] -= response[b].data()[i];
  for (std::size_t j = 0; j < data.distance.size(); ++j)
    for (std::size_t i = 0; i < data.distance[j].size(); ++i)
      data.distance[j].data()[i] += step.change[j].data()[i];
  return data;
}

}  // namespace

std::vector<PlaneF> AnswerToPixelSize(const PatchProblem& problem, const FitState& state) {
  for (const double step : {kPixelStep, kSmallPixelStep}) {
    std::vector<PlaneF> answer = AnswerToStep(problem, state, step);
    if (IsSeen(problem, answer, step)) return answer;
  }
  return {};
}

std::vector<PlaneF> AnswerToThickness(const PatchProblem& problem, const FitState& state,
                                      std::string_view profiles) {
  const ForwardModel& model = problem.model();
  const SkinPoint mean = MeanSkin(problem, state.maps);
  std::vector<SkinRow> rows;
  for (const BandOptics& optics : model.optics()) {
    const BandOptics::Node& node = optics.nodes[optics.center];
    for (const double step : {-kThicknessStep, kThicknessStep})
      rows.push_back({node.absorbers.MuAEpidermis(TableOne(mean)), node.absorbers.MuADermis(TableOne(mean)),
                      mean[kParameterCount], node.mu_s_epidermis, node.mu_s_dermis,
                      model.tissue().epidermis_thickness_mm * std::exp(step)});
  }
  const auto responses =
      HomogeneousSkin({.profiles = std::string(profiles)}, model.tissue()).Evaluate(rows, {});
  std::vector<PlaneF> answer(model.optics().size(), PlaneF(state.maps.width(), state.maps.height()));
  for (std::size_t b = 0; b < answer.size(); ++b) {
    const BandOptics& optics = model.optics()[b];
    const Absorbers& absorbers = optics.nodes[optics.center].absorbers;
    const double of_thickness =
        std::log(responses[2 * b + 1].reflectance / responses[2 * b].reflectance) / (2.0 * kThicknessStep);
    const auto of_absorption = [&](const SkinPoint& p) {
      return model.LocalSensitivity(static_cast<int>(b), TableOne(p), p[kParameterCount]).mu_a_epidermis *
             absorbers.MuAEpidermis(TableOne(p));
    };
    // A thicker epidermis absorbs as one with more absorbers does, wherever there are more of them.
    const double ratio = of_thickness / of_absorption(mean);
    for (std::size_t i = 0; i < answer[b].size(); ++i)
      answer[b].data()[i] = static_cast<float>(ratio * of_absorption(problem.PointAt(state.maps, i)));
  }
  return answer;
}

AssumptionCheck CheckAssumption(Assumption assumption, const std::vector<PlaneF>& answer,
                                const PatchProblem& problem, const FitState& state, const DetailView& detail,
                                const SkinPoint& fixed, double test_error) {
  const ParameterSpace& space = problem.space();
  AssumptionCheck check;
  check.assumption = assumption;
  if (answer.empty()) return check;
  std::vector<FreeVector> prior(detail.prior.begin(), detail.prior.end());
  if (assumption == Assumption::kThickness)
    for (FreeVector& variance : prior)
      for (int j = 0; j < space.count(); ++j)
        if (space.parameter(j) == Parameter::kJunctionAbsorbance) variance[j] = kClamped;
  DetailView without = detail;
  without.prior = prior;
  const std::vector<OctaveLevel> levels = LineariseInOctaves(problem, state);
  if (IsBounded(problem, levels)) {
    if (assumption == Assumption::kThickness)
      RefitUnder(answer, problem, state, detail, fixed, test_error, check);
    return check;
  }
  const std::optional<ForwardModel> other = WithTangent(problem.model());
  const ForwardModel::Kept render(other ? *other : problem.model(), state.maps);
  const Answered told = MakeUp(problem, state, render, answer, levels, without, fixed);
  Answered data = DataAt(problem, state, render, levels, without, fixed);
  check.maps = data.distance;
  for (int j = 0; j < space.count(); ++j)
    for (float& value : data.distance[j].values()) value -= static_cast<float>(space.mean()[j]);
  const double precision =
      Product(levels, problem.space(), without, told, told) + 1.0 / (kExpectedError * kExpectedError);
  check.log_error = Product(levels, problem.space(), without, told, data) / precision;
  check.log_evidence = LogEvidence(check.log_error, std::sqrt(1.0 / precision));
  check.sigma = std::sqrt(1.0 / precision + test_error * test_error);
  check.log_evidence_seen = LogEvidence(check.log_error, check.sigma);
  for (std::size_t j = 0; j < check.maps.size(); ++j)
    for (std::size_t i = 0; i < check.maps[j].size(); ++i)
      check.maps[j].data()[i] -= static_cast<float>(check.log_error * told.distance[j].data()[i]);
  return check;
}

}  // namespace dermap
