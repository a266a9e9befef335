// SPDX-License-Identifier: Apache-2.0
// Scenes up the ladder, each rendered as the engine chooses and by the full model.
#include "studies/ladder_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "studies/paired_time.h"
#include "studies/point_journal.h"
#include "studies/study_scenes.h"

namespace dermap {
namespace {

// The reference: every approximation far finer than any tolerance here.
constexpr double kReferenceTolerance = 1e-5, kReferenceMargin_mm = 4.0;
constexpr int kReferenceTerms = 20;
// Estimates are not asked to be right below what single precision and the tables leave anyway.
constexpr double kLeastError = 5e-5;

struct Scene {
  std::string name;
  std::function<ParameterMaps(int size)> maps;
  Illumination illumination = Illumination::kWindow;
  bool quick = false;  // part of the quick study
};

// Every pixel for itself: melanin within a factor of 2 of average skin.
ParameterMaps NoiseSkin(int size, std::uint64_t seed) {
  ParameterMaps maps(size, size, AverageSkin());
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> octave(-1.0, 1.0);
  for (float& melanin : maps[Parameter::kC_m].values())
    melanin *= static_cast<float>(std::exp2(octave(generator)));
  return maps;
}

std::vector<Scene> Scenes(std::uint64_t seed) {
  const auto uniform = [](ParameterVector skin) {
    return [skin](int size) { return ParameterMaps(size, size, skin); };
  };
  const auto freckles = [](double base, double contrast, double edge_mm) {
    return [=](int size) { return FreckledSkin(size, base, contrast, edge_mm); };
  };
  const auto shared = [](const char* name) { return [name](int size) { return StudySkin(name, size); }; };
  const ParameterVector lightest{0.01, 0.62, 0.002, 0.0, 0.01}, dark{0.4, 0.62, 0.005, 0.01, 0.05};
  constexpr Illumination kOn = Illumination::kUniform;
  return {{"uniform, light goes on", uniform(AverageSkin()), kOn, true},
          {"uniform, lit window", uniform(AverageSkin()), Illumination::kWindow, true},
          {"uniform and light, lit window", uniform(lightest)},
          {"uniform and dark, lit window", uniform(dark)},
          {"waves of 6 %, light goes on", freckles(0.06, 1.0, 1.0), kOn},
          {"waves of 6 %", freckles(0.06, 1.0, 1.0)},
          {"freckles x1.3, edge 1 mm", freckles(0.06, 1.3, 1.0)},
          {"freckles x1.3, edge 0.1 mm", freckles(0.06, 1.3, 0.1)},
          {"freckles x3, edge 1 mm", freckles(0.03, 3.0, 1.0)},
          {"freckles x3, edge 0.1 mm", freckles(0.03, 3.0, 0.1), Illumination::kWindow, true},
          {"freckles x3, a step, light goes on", freckles(0.03, 3.0, 0.0), kOn},
          {"freckles x10, edge 0.1 mm", freckles(0.03, 10.0, 0.1)},
          {"freckles x1.4 on dark skin", shared("dark"), Illumination::kWindow, true},
          {"a vein", shared("vein")},
          {"a tattoo", shared("tattoo")},
          {"every pixel for itself, x0.5 to x2", [seed](int size) { return NoiseSkin(size, seed); }},
          {"a step of melanin, 0.05 to 0.3", shared("step"), Illumination::kWindow, true}};
}

double RelativeRms(const PlaneF& found, const PlaneF& truth) {
  double square = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    square += std::pow(double(found.data()[i]) - truth.data()[i], 2);
    sum += truth.data()[i];
  }
  return std::sqrt(square * static_cast<double>(found.size())) / sum;
}

class Meter {
 public:
  Meter(int size, double budget_s) : size_(size), budget_s_(budget_s) {
    const auto bands = StudyBands();
    base_ = std::make_unique<ForwardModel>(Chromophores(ConfigDirectory() / "spectra"),
                                           *MakeProfileSource("exact"), TissueConfig{}, bands,
                                           ConditionsOf(Illumination::kWindow), ForwardOptions{});
  }

  ForwardModel Model(const Scene& scene, double tolerance) const {
    ForwardOptions options;
    options.tolerance = tolerance;
    return base_->With(ConditionsOf(scene.illumination)).With(options);
  }
  // What each band of a scene is given.
  std::vector<BandChoice> Choices(const Scene& scene, double tolerance) const {
    std::vector<BandChoice> choices;
    Model(scene, tolerance).Render(scene.maps(size_), {}, &choices);
    return choices;
  }

  // As much of everything as any band of any of the scenes is given.
  ForwardOptions FullModel(const std::vector<Scene>& scenes, double tolerance) const {
    ForwardOptions full;
    full.tolerance = tolerance;
    full.path_lengths = 1;
    full.terms = 1;
    full.margin_mm = 0.0;
    for (const Scene& scene : scenes)
      for (const BandChoice& choice : Choices(scene, tolerance)) {
        full.path_lengths = std::max({full.path_lengths, choice.epidermis_paths, choice.dermis_paths});
        full.terms = std::max(full.terms, choice.terms);
        full.margin_mm = std::max(full.margin_mm, choice.margin_mm);
      }
    return full;
  }

  LadderScene Measure(const Scene& scene, double tolerance, const ForwardOptions& full) const {
    LadderScene out;
    out.name = scene.name;
    out.tolerance = tolerance;
    const ParameterMaps maps = scene.maps(size_);
    const ForwardModel chosen = Model(scene, tolerance), always = chosen.With(full);
    ForwardOptions finest;
    finest.tolerance = kReferenceTolerance;
    finest.terms = kReferenceTerms;
    finest.margin_mm = kReferenceMargin_mm;
    const ForwardModel reference = chosen.With(finest);
    std::vector<BandChoice> choices;
    std::vector<PlaneF> found, truth;
    const PairedTime to_full = TimePaired([&] { found = chosen.Render(maps, {}, &choices); },
                                          [&] { always.Render(maps); }, budget_s_);
    const PairedTime to_reference =
        TimePaired([&] { chosen.Render(maps); }, [&] { truth = reference.Render(maps); }, budget_s_);
    out.times_faster = to_full.ratio;
    out.ratio_spread = to_full.ratio_spread;
    out.seconds = to_full.seconds / to_full.ratio;
    out.faster_than_reference = to_reference.ratio;
    for (std::size_t b = 0; b < found.size(); ++b) {
      out.bands.push_back(
          {chosen.optics()[b].band.wavelength_nm, choices[b], RelativeRms(found[b], truth[b])});
      out.error = std::max(out.error, out.bands.back().error);
      out.estimate = std::max(out.estimate, choices[b].error);
    }
    return out;
  }

 private:
  ImagingConditions ConditionsOf(Illumination illumination) const {
    return {.pixel_size_mm = kStudyPatch_mm / size_, .illumination = illumination};
  }
  int size_;
  double budget_s_;
  std::unique_ptr<ForwardModel> base_;
};

void Judge(LadderStudy& study) {
  double cost = 0.0, overconfident = 0.0;
  for (const LadderScene& scene : study.scenes) {
    cost = std::max(cost, scene.error / scene.tolerance);
    for (const LadderBand& band : scene.bands)
      overconfident = std::max(overconfident, band.error / std::max(band.choice.error, kLeastError));
  }
  study.verdicts = {{"what the choice costs stays within the tolerance: error over it", cost, 1.0},
                    {"the engine knows: true error over its estimate, in any band", overconfident, 3.0}};
}

}  // namespace

LadderStudy RunLadderStudy(const std::filesystem::path& folder, const LadderOptions& options,
                           const ProgressFunction& progress) {
  LadderStudy study;
  study.options = options;
  study.size = options.quick ? 48 : 128;
  study.machine = MachineName();
  const Meter meter(study.size, options.quick ? 0.0 : 1.0);
  const std::vector<double> tolerances =
      options.quick ? std::vector<double>{1e-3} : std::vector<double>{1e-3, 3e-3, 1e-2};
  std::vector<Scene> scenes = Scenes(options.seed);
  if (options.quick) std::erase_if(scenes, [](const Scene& scene) { return !scene.quick; });
  std::map<double, ForwardOptions> full;
  for (const double tolerance : tolerances) full[tolerance] = meter.FullModel(scenes, tolerance);
  const ForwardOptions& shipped = full.at(ForwardOptions{}.tolerance);
  study.full_paths = shipped.path_lengths;
  study.full_terms = shipped.terms;
  study.full_margin_mm = shipped.margin_mm;

  std::vector<PlannedPoint> plan;
  for (const double tolerance : tolerances)
    for (const Scene& scene : scenes)
      plan.push_back({fmt::format("{}, tolerance {:g}", scene.name, tolerance), 1.0, [&, tolerance] {
                        return LadderRecord(meter.Measure(scene, tolerance, full.at(tolerance)));
                      }});
  const nlohmann::json settings{{"study", "ladder"},
                                {"quick", options.quick},
                                {"seed", options.seed},
                                {"size", study.size},
                                {"machine", study.machine}};
  const PointRun run = RunPoints(folder, "ladder", settings, plan, progress);
  study.resumed = run.resumed;
  ReadRecords(run, [&](const nlohmann::json& record) { study.scenes.push_back(LadderSceneFrom(record)); });
  Judge(study);
  return study;
}

}  // namespace dermap
