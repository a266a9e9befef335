// SPDX-License-Identifier: Apache-2.0
// The default fit against the paper's own (plain gradient descent from average skin, 400 iterations, a render
// for each parameter's difference, by a cascade of blurs), 256 x 256 pixels and 8 bands, in one run. The
// descent itself is run at 32 pixels, whose renders are counted; what it would take at 256 is that number
// times a render's time there.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/files/atomic_file.h"
#include "common/optics/profile_source.h"
#include "fit/fit.h"
#include "studies/point_journal.h"
#include "studies/study_scenes.h"

namespace dermap {
namespace {

constexpr int kSize = 256, kDescentSize = 32, kRuns = 7, kRenders = 3;
constexpr double kNoise = 0.01;

struct Scene {
  ParameterMaps truth;
  ReflectanceStack stack;
};

ForwardModel ModelOf(const Chromophores& chromophores, int size, Engine engine) {
  ForwardOptions options;
  options.engine = engine;
  options.tolerance = 1e-4;
  ImagingConditions conditions;
  conditions.pixel_size_mm = kStudyPatch_mm / size;
  return {chromophores, *MakeProfileSource("exact"), {}, StudyBands(), conditions, options};
}

Scene SceneOf(const Chromophores& chromophores, const std::string& name, int size) {
  Scene scene{StudySkin(name, size), {}};
  const ForwardModel model = ModelOf(chromophores, size, Engine::kLowRank);
  scene.stack = NoisyStack(model, model.Render(scene.truth), kNoise, 1);
  return scene;
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// Median relative error of melanin.
double ErrorOf(const ParameterMaps& maps, const ParameterMaps& truth) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.planes[0].size(); ++i)
    errors.push_back(std::abs(maps.planes[0].data()[i] / truth.planes[0].data()[i] - 1.0));
  return Median(std::move(errors));
}

double SecondsOfCascade(const Chromophores& chromophores, const ParameterMaps& maps) {
  const ForwardModel cascade = ModelOf(chromophores, kSize, Engine::kCascade);
  cascade.Render(maps);
  std::vector<double> seconds;
  for (int run = 0; run < kRenders; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    cascade.Render(maps);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return Median(std::move(seconds));
}

FitResult Descent(const Chromophores& chromophores, const Scene& scene) {
  FitOptions options;
  options.method = FitMethod::kDescent;
  options.metric = DescentMetric::kPlain;
  options.forward.engine = Engine::kCascade;
  options.stop_chi2 = 0.0;
  options.size = kDescentSize;
  return FitStack(scene.stack, options, chromophores);
}

nlohmann::json Measure(const Chromophores& chromophores, const std::string& name) {
  const Scene scene = SceneOf(chromophores, name, kSize);
  FitOptions options;
  options.size = kSize;
  std::vector<double> seconds;
  FitResult fit = FitStack(scene.stack, options, chromophores);  // fills the caches of tables
  for (int run = 0; run < kRuns; ++run) {
    fit = FitStack(scene.stack, options, chromophores);
    seconds.push_back(fit.seconds);
  }
  const double fast = Median(seconds), error = ErrorOf(fit.maps, scene.truth);
  const double render = SecondsOfCascade(chromophores, scene.truth);
  const Scene small = SceneOf(chromophores, name, kDescentSize);
  const FitResult descent = Descent(chromophores, small);
  const double descent_error = ErrorOf(descent.maps, small.truth);
  const double descent_seconds = descent.renders * render;
  std::printf(
      "%-16s fast %.2f s (C_m off by %.1f %%), cascade %.2f s a render, descent %d renders: %.0f s "
      "(%.1f %%), ratio %.0f\n",
      name.c_str(), fast, 100.0 * error, render, descent.renders, descent_seconds, 100.0 * descent_error,
      descent_seconds / fast);
  const auto entry = [](double value, double off) {
    return nlohmann::json{{"value", value}, {"error", off}};
  };
  return {{"fit_seconds", entry(fast, error)},
          {"cascade_render_seconds", entry(render, 0.0)},
          {"descent_renders", entry(descent.renders, descent_error)},
          {"descent_seconds_extrapolated", entry(descent_seconds, descent_error)},
          {"speedup_over_descent", entry(descent_seconds / fast, error)}};
}

}  // namespace
}  // namespace dermap

int main(int argc, char** argv) try {
  using namespace dermap;
  const std::string flag = "--summary=";
  std::string path;
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]).starts_with(flag)) path = std::string(argv[i]).substr(flag.size());
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  nlohmann::json json{{"machine", MachineName()}, {"size", kSize}, {"bands", StudyBands().size()}};
  for (const char* name : {"light", "medium", "vein"}) json["scenes"][name] = Measure(chromophores, name);
  if (!path.empty()) WriteFileAtomically(path, json.dump(2) + "\n");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "fit_bench: %s\n", error.what());
  return 2;
}
