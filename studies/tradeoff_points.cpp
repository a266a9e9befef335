// SPDX-License-Identifier: Apache-2.0
// One setting on one scene: its time beside the default's, its error against what is more right than it.
#include "studies/tradeoff_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "fit/fit.h"
#include "fit/resample.h"
#include "studies/noise_bound.h"
#include "studies/paired_time.h"
#include "studies/study_scenes.h"

namespace dermap {
namespace {

constexpr int kCells = 32;  // errors of renders are of areas of 7.5 / 32 = 0.23 mm
// The slow reference: the engine with both ends, every approximation far finer than any setting asks for.
constexpr double kReferenceTolerance = 1e-5, kReferenceMargin_mm = 4.0;
constexpr int kReferenceTerms = 20;
constexpr double kNoise = 0.01;       // of the reflectance, in fits
constexpr double kMonteCarlo = 1e-9;  // "has a Monte Carlo", where its error is nil

std::string InWords(const std::string& profiles, const ForwardOptions& f, double tolerance) {
  const bool lowrank = f.engine == Engine::kLowRank;
  const auto count = [](int n, int automatic) { return n == automatic ? "automatic" : std::to_string(n); };
  const std::string sum = lowrank
                              ? fmt::format("tolerance {}, path lengths {}",
                                            tolerance > 0.0 ? fmt::format("{:g}", tolerance) : "automatic",
                                            count(f.path_lengths, kAutomaticPaths))
                              : fmt::format("{} Gaussians", kGaussianCount / f.gaussian_step);
  return fmt::format("{} profiles, {}, {}, {}, terms {}{}", profiles, EngineName(f.engine),
                     lowrank && f.coupling == Coupling::kReciprocal ? "both ends of a path" : "exit alone",
                     sum, count(f.terms, kAutomaticTerms), f.close_series ? "" : ", the rest left out");
}

std::vector<PlaneF> Cells(std::vector<PlaneF> planes) {
  for (PlaneF& plane : planes) plane = AverageTo(plane, kCells);
  return planes;
}

// Relative rms over all bands, and the standard error of its mean over the bands.
struct Deviation {
  double rms = 0.0, bar = 0.0;
};
Deviation Deviate(const std::vector<PlaneF>& found, const std::vector<PlaneF>& truth) {
  std::vector<double> squares;
  for (std::size_t b = 0; b < found.size(); ++b) {
    double square = 0.0;
    for (std::size_t i = 0; i < truth[b].size(); ++i)
      square += std::pow(double(found[b].data()[i]) / truth[b].data()[i] - 1.0, 2);
    squares.push_back(square / static_cast<double>(truth[b].size()));
  }
  const auto count = static_cast<double>(squares.size());
  double mean = 0.0, spread = 0.0;
  for (const double s : squares) mean += std::sqrt(s) / count, spread += s / count;
  const double rms = std::sqrt(spread);
  return {rms, std::sqrt(std::max(0.0, spread - mean * mean) / count)};
}

// Likewise without the judge's own noise; what that noise hides is the bar.
Deviation NetDeviation(const std::vector<PlaneF>& found, const ReflectanceStack& judge) {
  double square = 0.0, noise = 0.0, count = 0.0;
  for (std::size_t b = 0; b < found.size(); ++b)
    for (std::size_t i = 0; i < found[b].size(); ++i, ++count) {
      const double truth = judge.reflectance[b].data()[i];
      square += std::pow(found[b].data()[i] / truth - 1.0, 2);
      noise += std::pow(judge.sigma[b].data()[i] / truth, 2);
    }
  const double hidden = noise / count * std::sqrt(2.0 / count);  // standard error of the difference
  const double net = std::max(square / count - noise / count, 0.0);
  const double floor = std::sqrt(hidden);
  const double rms = std::max(std::sqrt(net), floor);
  return {rms, 0.5 * hidden / rms};
}

// Median errors over what noise leaves a pixel by itself, mean of the parameters; its standard error from the
// spread of the patch's four quarters, since neighbouring pixels err together.
Deviation OverBound(const ParameterMaps& found, const ParameterMaps& truth, const ParameterVector& bound) {
  const auto measure = [&](const std::vector<char>& use) {
    const ParameterVector errors = MedianErrors(found, truth, use);
    double mean = 0.0;
    for (int k = 0; k < kParameterCount; ++k)
      mean += errors[k] / (kMedianOverSigma * bound[k]) / kParameterCount;
    return mean;
  };
  double sum = 0.0, squares = 0.0;
  for (int quarter = 0; quarter < 4; ++quarter) {
    std::vector<char> use(truth.planes[0].size());
    for (std::size_t i = 0; i < use.size(); ++i) {
      const int x = static_cast<int>(i) % truth.width(), y = static_cast<int>(i) / truth.width();
      use[i] = (2 * x >= truth.width()) + 2 * (2 * y >= truth.height()) == quarter;
    }
    const double value = measure(use);
    sum += value / 4.0;
    squares += value * value / 4.0;
  }
  return {measure({}), std::sqrt(std::max(0.0, squares - sum * sum) / 3.0)};
}

// Of `times` as many as were timed.
void SetTime(const PairedTime& time, double times, TradeoffPoint& point) {
  point.seconds = time.seconds * times;
  point.ratio = time.ratio * times;
  point.ratio_spread = time.ratio_spread;
  point.pairs = time.pairs;
}

}  // namespace

struct TradeoffMeter::Impl {
  int size;
  std::uint64_t seed;
  double budget_s;
  Chromophores chromophores{ConfigDirectory() / "spectra"};
  std::map<std::string, std::unique_ptr<ProfileSource>> sources;
  std::map<std::string, std::unique_ptr<ForwardModel>> models;  // by profiles

  struct Scene {
    std::string name;
    ParameterMaps truth;
    std::vector<PlaneF> reference;          // the slow render, cells
    std::optional<ReflectanceStack> stack;  // what is fitted
    ParameterMaps truth_of_stack, reference_fit;
    ParameterVector bound{};
  };
  Scene render_scene, fit_scene;

  ForwardModel Model(const std::string& profiles, const ForwardOptions& options, int pixels) {
    auto& model = models[profiles];
    if (!model) {
      const auto source = MakeProfileSource(profiles);
      const auto bands = StudyBands();
      model = std::make_unique<ForwardModel>(chromophores, *source, TissueConfig{}, bands,
                                             ImagingConditions{.pixel_size_mm = kStudyPatch_mm / pixels},
                                             ForwardOptions{});
    }
    return model->With(ImagingConditions{.pixel_size_mm = kStudyPatch_mm / pixels}).With(options);
  }
  ForwardModel Slow() {
    ForwardOptions options;
    options.tolerance = kReferenceTolerance;
    options.terms = kReferenceTerms;
    options.margin_mm = kReferenceMargin_mm;
    return Model("exact", options, size);
  }

  void SeeRenderScene(const std::string& name) {
    if (render_scene.name == name) return;
    render_scene = {};
    render_scene.truth = StudySkin(name, size);
    render_scene.reference = Cells(Slow().Render(render_scene.truth));
    render_scene.name = name;
  }

  void SeeFitScene(const std::string& name) {
    if (fit_scene.name == name) return;
    fit_scene = {};
    if (name == "monte_carlo_skin") {
      fit_scene.stack = MonteCarloStack();
      fit_scene.truth_of_stack = StudySkin(name, fit_scene.stack->width());
      fit_scene.stack->pixel_size_mm = kStudyPatch_mm / fit_scene.stack->width();
    } else {
      fit_scene.truth_of_stack = StudySkin(name, size);
      const ForwardModel slow = Slow();
      fit_scene.stack = NoisyStack(slow, slow.Render(fit_scene.truth_of_stack), kNoise, seed);
    }
    const int pixels = fit_scene.stack->width();
    fit_scene.bound =
        NoiseBound(Model("exact", {}, pixels), fit_scene.truth_of_stack, fit_scene.stack->sigma);
    fit_scene.reference_fit = FitStack(*fit_scene.stack, ReferenceFit(pixels), chromophores).maps;
    fit_scene.name = name;
  }
};

TradeoffMeter::TradeoffMeter(int size, std::uint64_t seed, double budget_s) : impl_(new Impl) {
  impl_->size = size;
  impl_->seed = seed;
  impl_->budget_s = budget_s;
}
TradeoffMeter::~TradeoffMeter() = default;

TradeoffPoint TradeoffMeter::Render(const RenderSetting& setting, const std::string& scene) {
  impl_->SeeRenderScene(scene);
  const Impl::Scene& seen = impl_->render_scene;
  TradeoffPoint point{.kind = "render", .scene = scene, .setting = setting.name, .family = setting.family};
  point.options = InWords(setting.profiles, setting.forward, setting.forward.tolerance);
  point.size = setting.size;
  point.is_default = setting.is_default;
  point.is_paper = setting.is_paper;
  const ForwardModel model = impl_->Model(setting.profiles, setting.forward, setting.size);
  const ForwardModel yardstick = impl_->Model("exact", {}, impl_->size);
  const ParameterMaps maps = AverageTo(seen.truth, setting.size);
  std::vector<PlaneF> rendered;
  const PairedTime time = TimePaired([&] { yardstick.Render(seen.truth); },
                                     [&] { rendered = model.Render(maps); }, impl_->budget_s);
  SetTime(time, 1.0, point);
  rendered = Cells(std::move(rendered));
  const Deviation deviation = Deviate(rendered, seen.reference);
  point.error = deviation.rms;
  point.error_bar = deviation.bar;
  if (scene == "monte_carlo_skin") {
    const Deviation net = NetDeviation(rendered, MonteCarloStack());
    point.error_monte_carlo = std::max(net.rms, kMonteCarlo);
    point.monte_carlo_bar = net.bar;
  }
  return point;
}

double TradeoffMeter::Rounding(const std::string& scene) {
  impl_->SeeRenderScene(scene);
  const ParameterMaps& truth = impl_->render_scene.truth;
  const ForwardModel model = impl_->Model("exact", {}, impl_->size);
  const PlaneF third(truth.width(), truth.height(), 1.0f / 3.0f);
  const std::vector<PlaneF> all = model.Render(truth);
  std::vector<PlaneF> thirds = model.Render(truth, {&third, 1});
  double worst = 0.0;
  for (std::size_t b = 0; b < all.size(); ++b) {
    for (float& value : thirds[b].values()) value *= 3.0f;
    worst = std::max(worst, Deviate({thirds[b]}, {all[b]}).rms);
  }
  return worst;
}

TradeoffPoint TradeoffMeter::Fit(const FitSetting& setting, const std::string& scene) {
  impl_->SeeFitScene(scene);
  const Impl::Scene& seen = impl_->fit_scene;
  const int pixels = seen.stack->width();
  TradeoffPoint point{.kind = "fit", .scene = scene, .setting = setting.name, .family = setting.family};
  FitOptions options = setting.options;
  // The scene may be smaller than the study's patches; settings keep their share of it, down to 8 pixels.
  if (!setting.is_paper) options.size = std::max(8, options.size * pixels / impl_->size);
  options.size = std::min(options.size, pixels);
  point.options = fmt::format("{}, {}", NameOf(options.method),
                              InWords(options.profiles, options.forward, options.tolerance));
  point.is_default = setting.is_default;
  point.is_paper = point.extrapolated = setting.is_paper;
  FitOptions shipped;
  shipped.size = pixels;
  FitResult found;
  const auto fit = [&] { found = FitStack(*seen.stack, options, impl_->chromophores); };
  const auto yardstick = [&] { FitStack(*seen.stack, shipped, impl_->chromophores); };
  if (setting.is_paper) {  // far too slow for pairs: its renders times the time of one at full size
    fit();
    const ForwardModel model = impl_->Model(options.profiles, options.forward, pixels);
    const PairedTime render = TimePaired(
        yardstick, [&] { model.Render(seen.truth_of_stack); }, impl_->budget_s);
    // 400 iterations with a difference for each parameter [D08 6.3], also where fewer were run.
    SetTime(render, 400.0 * (1.0 + kParameterCount), point);
  } else {
    SetTime(TimePaired(yardstick, fit, impl_->budget_s), 1.0, point);
  }
  point.size = found.maps.width();
  point.chi2 = found.chi2;
  point.renders = found.renders;
  const ParameterMaps maps = ResizeLinear(found.maps, pixels, pixels);
  point.to_truth = MedianErrors(maps, seen.truth_of_stack);
  point.to_reference = MedianErrors(maps, seen.reference_fit);
  point.bound = seen.bound;
  const Deviation truth = OverBound(maps, seen.truth_of_stack, seen.bound),
                  reference = OverBound(maps, seen.reference_fit, seen.bound);
  point.error = truth.rms;
  point.error_bar = truth.bar;
  point.error_reference = reference.rms;
  point.reference_bar = reference.bar;
  if (scene == "monte_carlo_skin") {
    const int m = static_cast<int>(Parameter::kC_m);
    const std::span<const float> melanin = seen.truth_of_stack.planes[m].values();
    point.error_monte_carlo =
        std::max(point.to_truth[m] / MedianOrNaN({melanin.begin(), melanin.end()}), kMonteCarlo);
    point.monte_carlo_bar = point.error_monte_carlo * 1.17 / std::sqrt(double(melanin.size()));
  }
  return point;
}

}  // namespace dermap
