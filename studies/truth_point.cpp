// SPDX-License-Identifier: Apache-2.0
// Errors counted, beside their bounds and their error bars.
#include "studies/truth_point.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "common/core/error.h"
#include "fit/fit.h"
#include "fit/parameter_space.h"
#include "fit/scene_choice.h"
#include "studies/coupled_bound.h"
#include "studies/noise_bound.h"
#include "studies/study_scenes.h"

namespace dermap {
namespace {

constexpr double kTruthTolerance = 1e-5;

std::vector<Parameter> FreeSet(const std::string& name) {
  if (name == "auto") return {};
  std::vector<Parameter> all = AllUnknowns();
  if (name == "paper") std::erase(all, Parameter::kJunctionAbsorbance);  // table 1
  return all;
}

PlaneF TruthOf(const ParameterMaps& maps, Parameter p, double base) {
  if (p != Parameter::kJunctionAbsorbance) return maps[p];
  return maps.junction_absorbance.empty() ? PlaneF(maps.width(), maps.height(), static_cast<float>(base))
                                          : maps.junction_absorbance[0];
}

struct Tally {
  double errors = 0.0, pixels = 0.0;                   // squares
  double bounds = 0.0, told_errors = 0.0, told = 0.0;  // of identifiable pixels
  double all_bounds = 0.0;
  double squares = 0.0, claimed = 0.0;
  std::array<double, kIntervals.size()> covered{};
  bool free = true;
};

double RangeSigma(Parameter p) {
  return (InfoOf(p).upper - InfoOf(p).lower) / std::sqrt(12.0);
}

void Count(const FitResult& fit, Parameter p, const PlaneF& truth, const PlaneF* bound, Tally& tally) {
  const PlaneF found = TruthOf(fit.maps, p, kJunctionInfo.mean);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double error = double(found.data()[i]) - truth.data()[i];
    tally.errors += error * error;
    tally.pixels += 1.0;
    if (bound) {
      const double limit = bound->data()[i];
      tally.all_bounds += limit * limit;
      if (limit <= kIdentifiable * RangeSigma(p)) {
        tally.told += 1.0;
        tally.told_errors += error * error;
        tally.bounds += limit * limit;
      }
    }
    if (!tally.free || (fit.flags.data()[i] & ~kFlagNotIdentifiable) != 0) continue;
    const double sigma = fit.sigma.Unknown(p).data()[i];
    if (!(sigma > 0.0) || sigma > kIdentifiable * RangeSigma(p)) continue;
    const double scaled = std::abs(error) / sigma;
    tally.claimed += 1.0;
    tally.squares += scaled * scaled;
    for (std::size_t k = 0; k < kIntervals.size(); ++k)
      tally.covered[k] += scaled <= kIntervals[k].half_length;
  }
}

double Share(double part, double whole) {
  return whole > 0.0 ? part / whole : std::numeric_limits<double>::quiet_NaN();
}

TruthParameter Conclude(const Tally& tally, bool bound) {
  TruthParameter p;
  p.free = tally.free;
  p.error = std::sqrt(Share(tally.errors, tally.pixels));
  const bool bounded = bound && tally.free;
  p.bound = std::sqrt(Share(tally.all_bounds, bounded ? tally.pixels : 0.0));
  p.identifiable = Share(tally.told, bounded ? tally.pixels : 0.0);
  p.over_bound = std::sqrt(Share(tally.told_errors, tally.bounds));
  p.claimed = Share(tally.claimed, tally.pixels);
  p.spread = std::sqrt(Share(tally.squares, tally.claimed));
  for (std::size_t k = 0; k < kIntervals.size(); ++k) p.covered[k] = Share(tally.covered[k], tally.claimed);
  return p;
}

}  // namespace

struct TruthBench::Scene {
  std::string name;
  int size = 0;
  double noise = 0.0;
  ParameterMaps truth;
  Chromophores chromophores{ConfigDirectory() / "spectra"};
  std::unique_ptr<ForwardModel> model;
  std::vector<PlaneF> reflectance;
  std::unique_ptr<CoupledInformation> information;

  std::vector<PlaneF> Bound(const std::vector<Parameter>& free) {
    if (!information) {
      std::vector<PlaneF> sigma = reflectance;
      for (PlaneF& plane : sigma)
        for (float& value : plane.values()) value *= static_cast<float>(noise);
      information = std::make_unique<CoupledInformation>(model->With(ForwardOptions{}), truth, sigma);
    }
    return information->Bound(free);
  }
};

TruthBench::TruthBench() : scene_(new Scene) {}
TruthBench::~TruthBench() = default;

void TruthBench::See(const TruthSetting& setting) {
  Scene& scene = *scene_;
  if (scene.name == setting.scene && scene.size == setting.size && scene.noise == setting.noise) return;
  scene.name = setting.scene;
  scene.size = setting.size;
  scene.noise = setting.noise;
  scene.truth = StudySkin(setting.scene, setting.size);
  ForwardOptions options;
  options.tolerance = kTruthTolerance;
  const ImagingConditions conditions{.pixel_size_mm = kStudyPatch_mm / setting.size};
  scene.model = std::make_unique<ForwardModel>(scene.chromophores, *MakeProfileSource("exact"),
                                               TissueConfig{}, StudyBands(), conditions, options);
  scene.reflectance = scene.model->Render(scene.truth);
  scene.information.reset();
}

TruthPoint TruthBench::Measure(const TruthSetting& setting) {
  See(setting);
  TruthPoint point;
  point.scene = setting.scene;
  point.free = setting.free;
  point.size = setting.size;
  point.draws = setting.draws;
  std::array<Tally, kUnknownCount> tallies;
  std::map<std::vector<Parameter>, std::vector<PlaneF>> bounds;
  FitOptions options;
  options.free_parameters = FreeSet(setting.free);
  options.size = setting.size;
  for (int draw = 0; draw < setting.draws; ++draw) {
    ReflectanceStack stack =
        NoisyStack(*scene_->model, scene_->reflectance, setting.noise, setting.seed + draw);
    stack.shared_error = 0.0;
    const FitResult fit = FitStack(stack, options, scene_->chromophores);
    const std::vector<Parameter>& free = fit.free_parameters;
    if (draw == 0) point.chosen = NamesOf(free);
    point.chi2 += fit.chi2 / setting.draws;
    auto& bound = bounds[free];
    if (setting.bound && bound.empty()) bound = scene_->Bound(free);
    for (const Parameter p : AllUnknowns()) {
      const auto at = std::find(free.begin(), free.end(), p) - free.begin();
      Tally& tally = tallies[static_cast<std::size_t>(p)];
      const bool is_free = at < static_cast<std::ptrdiff_t>(free.size());
      tally.free &= is_free;
      Count(fit, p, TruthOf(scene_->truth, p, scene_->model->tissue().junction_absorbance),
            setting.bound && is_free ? &bound[static_cast<std::size_t>(at)] : nullptr, tally);
    }
  }
  for (std::size_t k = 0; k < tallies.size(); ++k) point.parameters[k] = Conclude(tallies[k], setting.bound);
  return point;
}

MonteCarloFit MeasureMonteCarloFit() {
  ReflectanceStack stack = MonteCarloStack();
  const ParameterMaps truth = StudySkin("monte_carlo_skin", stack.width());
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  FitOptions options;
  options.size = stack.width();
  const FitResult fit = FitStack(stack, options, chromophores);
  MonteCarloFit result;
  result.bands = static_cast<int>(stack.bands.size());
  std::vector<double> melanin, melanin_size, blood, blood_size;
  const auto relative = [&](Parameter p, std::size_t i) {
    return double(fit.maps[p].data()[i]) / truth[p].data()[i] - 1.0;
  };
  for (std::size_t i = 0; i < fit.flags.size(); ++i) {
    melanin.push_back(relative(Parameter::kC_m, i));
    melanin_size.push_back(std::abs(melanin.back()));
    if (fit.sigma[Parameter::kC_hd].data()[i] > 0.5 * fit.maps[Parameter::kC_hd].data()[i]) continue;
    blood.push_back(relative(Parameter::kC_hd, i));
    blood_size.push_back(std::abs(blood.back()));
  }
  result.blood_known = Share(static_cast<double>(blood.size()), static_cast<double>(melanin.size()));
  result.melanin_bias = MedianOrNaN(std::move(melanin));
  result.melanin_median = MedianOrNaN(melanin_size);
  result.melanin_decile = QuantileOrNaN(std::move(melanin_size), 0.9);
  result.blood_bias = MedianOrNaN(std::move(blood));
  result.blood_median = MedianOrNaN(std::move(blood_size));
  return result;
}

}  // namespace dermap
