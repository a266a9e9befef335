// SPDX-License-Identifier: Apache-2.0
// dermap fit STACK.exr -o DIR: the chromophore maps of a reflectance stack, with a report.
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/atomic_file.h"
#include "common/files/tissue_config.h"
#include "fit/fit.h"
#include "fit/report.h"
#include "fit/write_fit.h"

namespace dermap {
namespace {

struct FitArguments {
  std::filesystem::path stack;
  std::filesystem::path output;
  std::filesystem::path config;
  std::filesystem::path truth;
  bool resume = false;
  std::filesystem::path prior;
  std::filesystem::path save_prior;
  std::string method = "fast", metric = "curvature", start = "average", free = "auto";
  std::string engine{EngineName(ForwardOptions{}.engine)};
  std::string beneath_tape{NameOf(BeneathTape::kEdge)};
  double pixel_size_mm = 0.0;
  FitOptions options;
};

volatile std::sig_atomic_t g_stop = 0;

// The first signal has the fit end where it stands and write what is there; a second one ends at once.
void StopOnSignals() {
  struct sigaction action {};
  action.sa_handler = [](int) { g_stop = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

void AddOptions(CLI::App& app, FitArguments& args) {
  app.add_option("STACK", args.stack,
                 "Reflectance stack, .exr or ENVI .hdr, from any rig; a .csv of spectra has flags of its "
                 "own: dermap fit SPECTRA.csv --help")
      ->required();
  app.add_option("-o,--output", args.output, "The fit folder to write")->required();
  app.add_option("--method", args.method, "fast (default) | descent | ceres (the reference)");
  app.add_option(
      "--start", args.start,
      "descent starts from: average (default, [D08 6.3]) | local inversion | random, as ceres may");
  app.add_option("--seed", args.options.seed, "Of --start random (default 1)");
  app.add_option("--metric", args.metric, "descent steps along: curvature (default) | plain gradient");
  app.add_option("--profiles", args.options.profiles,
                 "Source of the profiles (default " + args.options.profiles + ")");
  app.add_option("--engine", args.engine, "lowrank | pyramid | cascade (default " + args.engine + ")");
  app.add_option("--beneath-tape", args.beneath_tape,
                 "Skin there: edge (default: as at the window's edge) | mirrored | mean");
  app.add_option("--shared-error", args.options.shared_error,
                 "Error that all pixels of a band share, relative (default: the stack's, else 0.001)")
      ->check(Within(0.0, 0.1));
  app.add_option("--tolerance", args.options.tolerance,
                 "How far a render may be off, relative (default 0: a tenth of the noise)")
      ->check(Within(0.0, 0.1));
  app.add_option("--free", args.free,
                 "auto (default: by evidence), or names: C_m,beta_m,C_he,C_bc,C_hd,junction_absorbance");
  app.add_option("--pixel-size-mm", args.pixel_size_mm, "Instead of the stack's own")
      ->check(Within(1e-4, 100.0));
  app.add_option("--size", args.options.size,
                 "Fit at this many pixels along the longer side (default 0: by time)")
      ->check(Within(0, 8192));
  app.add_option("--time-budget-s", args.options.time_budget_s,
                 "Seconds that the size is chosen for (default 60)")
      ->check(Within(0.1, 1e6));
  app.add_option("--max-iterations", args.options.max_iterations,
                 "Of descent and ceres (default 400 [D08 6.3])")
      ->check(Within(1, 1000000));
  app.add_option("--stop-chi2", args.options.stop_chi2, "descent stops at this chi2 (default 1.02; 0: never)")
      ->check(Within(0.0, 1e9));
  app.add_option("--config", args.config, "TOML with a [tissue] table");
  CLI::Option* prior =
      app.add_option("--prior", args.prior, "What earlier fits found, for images of few bands such as RGB");
  app.add_option("--save-prior", args.save_prior,
                 "Write what this fit teaches for --prior, or add it to the file that is there")
      ->excludes(prior);
  app.add_flag("--resume", args.resume, "Go on with the interrupted fit in the output folder");
  app.add_option("--truth", args.truth, "maps.exr of a simulated scene, shown beside the maps in the report");
}

void Resolve(FitArguments& args) {
  args.options.method = FitMethodFromName(args.method);
  args.options.metric = DescentMetricFromName(args.metric);
  args.options.start = StartPointFromName(args.start);
  args.options.forward.engine = EngineFromName(args.engine);
  args.options.forward.beneath_tape = BeneathTapeFromName(args.beneath_tape);
  args.options.free_parameters = FreeParametersFromText(args.free);
  if (args.pixel_size_mm > 0.0) args.options.pixel_size_mm = args.pixel_size_mm;
  if (!args.prior.empty()) args.options.prior = ReadLearntPrior(args.prior);
  if (args.resume) args.options.resume = ReadUnfinishedFit(args.output);
  if (!args.config.empty()) args.options.tissue = ReadTissueConfig(args.config);
}

// The prior on disk with this fit added. Read before a fit, so that a damaged file costs no time.
class PriorToSave {
 public:
  explicit PriorToSave(std::filesystem::path path) : path_(std::move(path)) {
    if (!path_.empty() && std::filesystem::exists(path_)) before_ = ReadLearntPrior(path_);
  }
  void Save(const FitResult& fit, const std::string& name) const {
    if (path_.empty() || !fit.finished) return;
    const LearntPrior own = LearnFrom(fit, name);
    WriteLearntPrior(path_, before_ ? Combined(*before_, own) : own);
  }

 private:
  std::filesystem::path path_;
  std::optional<LearntPrior> before_;
};

Outcome Summarize(const FitResult& fit, const std::filesystem::path& directory) {
  Outcome outcome;
  outcome.code = fit.converged && fit.Explained() ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
  char line[300];
  std::snprintf(line, sizeof line,
                "%s, %s profiles, %d x %d pixels, %zu bands: rms residual %.5f, chi2 per degree of freedom "
                "%.3f, %d renders, "
                "%.1f s%s\n",
                fit.method.c_str(), fit.profiles.c_str(), fit.maps.width(), fit.maps.height(),
                fit.bands.size(), fit.rms_residual, fit.chi2, fit.renders, fit.seconds,
                !fit.finished      ? ", INTERRUPTED"
                : !fit.converged   ? ", NOT CONVERGED"
                : !fit.Explained() ? ", DATA NOT EXPLAINED"
                                   : "");
  outcome.text = line;
  for (const std::string& decision : fit.decisions) outcome.text += "  " + decision + "\n";
  outcome.text += (directory / "report.html").string() + "\n";
  outcome.fill_json = [fit, directory](nlohmann::json& json) {
    json = nlohmann::json(FitRecord(fit));
    json["directory"] = directory.string();
    json["report"] = (directory / "report.html").string();
  };
  return outcome;
}

}  // namespace

int RunFitCommand(int argc, char** argv) {
  if (MeansSpectra(argc, argv)) return RunFitSpectraCommand(argc, argv);
  CommandLine command("fit",
                      "Recover the chromophore maps of a reflectance stack, with error bars and a report.");
  FitArguments args;
  AddOptions(command.app(), args);
  return command.Run(argc, argv, [&] {
    StopOnSignals();
    Resolve(args);
    args.options.stop = [] { return g_stop != 0; };
    const ReflectanceStack stack = ReadReflectanceStack(args.stack);
    std::optional<MapsFile> truth;
    if (!args.truth.empty()) truth = ReadMaps(args.truth);
    const std::filesystem::path spectra = ConfigDirectory() / "spectra";
    const PriorToSave prior(args.save_prior);
    ProgressBar bar("fit");
    const FitResult fit = FitStack(stack, args.options, Chromophores(spectra), bar.Function());
    FileBatch folder;  // all of it, or nothing
    WriteFit(args.output, fit);
    WriteMapPreviews(args.output, fit, spectra);
    WriteReport(args.output / "report.html", {.fit = fit,
                                              .name = args.stack.filename().string(),
                                              .spectra_dir = spectra,
                                              .truth = truth ? &*truth : nullptr,
                                              .calibration = CalibrationSidecar(args.stack)});
    prior.Save(fit, args.stack.filename().string());
    folder.Commit();
    return Summarize(fit, args.output);
  });
}

}  // namespace dermap
