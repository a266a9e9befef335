// SPDX-License-Identifier: Apache-2.0
// dermap study NAME -o DIR: the charts that belong to the product, one sub-command each.
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string_view>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/picture.h"
#include "studies/optics_study.h"
#include "studies/sharpness_study.h"

namespace dermap {
namespace {

int RunOpticsStudyCommand(int argc, char** argv) {
  CommandLine command("study optics",
                      "How wrong the optics are over mu_a, against adding-doubling and Monte Carlo.");
  std::filesystem::path folder;
  OpticsStudyOptions options;
  command.app()
      .add_option("-o,--output", folder, "The folder to write optics.{csv,json,svg,html} to")
      ->required();
  command.app().add_flag("--quick", options.quick, "Few points and photons: seconds instead of minutes");
  command.app().add_option("--seed", options.seed, "Of the Monte Carlo (default 1)");
  return command.Run(argc, argv, [&] {
    ProgressBar bar("study optics");
    const OpticsStudy study = RunOpticsStudy(options, bar.Function());
    WriteOpticsStudy(folder, study);
    Outcome outcome;
    outcome.code = study.AllHold() ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
    for (const OpticsVerdict& v : study.verdicts) {
      outcome.text += (v.holds() ? "holds  " : "FAILS  ") + v.claim + ": " + FormatValue(v.worst) +
                      " (limit " + FormatValue(v.limit) + ")\n";
    }
    outcome.text += (folder / "optics.html").string() + "\n";
    outcome.fill_json = [study, folder](nlohmann::json& json) {
      json = {{"page", (folder / "optics.html").string()}, {"verdicts", nlohmann::json::array()}};
      for (const OpticsVerdict& v : study.verdicts) {
        json["verdicts"].push_back(
            {{"claim", v.claim}, {"worst", v.worst}, {"limit", v.limit}, {"holds", v.holds()}});
      }
    };
    return outcome;
  });
}

int RunSharpnessStudyCommand(int argc, char** argv) {
  CommandLine command("study sharpness",
                      "How far the forward model is from Monte Carlo beside an edge, over the edge's width.");
  std::filesystem::path folder;
  SharpnessStudyOptions options;
  command.app()
      .add_option("-o,--output", folder, "The folder to write sharpness.{csv,json,svg} to")
      ->required();
  command.app().add_flag("--quick", options.quick, "Few edges and photons");
  command.app().add_option("--seed", options.seed, "Of the Monte Carlo (default 1)");
  return command.Run(argc, argv, [&] {
    ProgressBar bar("study sharpness");
    const SharpnessStudy study = RunSharpnessStudy(options, bar.Function());
    WriteSharpnessStudy(folder, study);
    Outcome outcome;
    outcome.code = study.AllHold() ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
    for (const SharpnessPoint& p : study.points) {
      outcome.text += fmt::format(
          "edge {:4.1f} mean free paths wide: reciprocal {:.4f}, gather {:.4f}, as published {:.4f} (judge's "
          "noise "
          "{:.4f})\n",
          p.width_per_mean_free_path, p.reciprocal.net, p.gather.net, p.published.net, p.reciprocal.noise);
    }
    outcome.text += (folder / "sharpness.svg").string() + "\n";
    outcome.fill_json = [study, folder](nlohmann::json& json) {
      json = {{"chart", (folder / "sharpness.svg").string()},
              {"gather_edge_mean_free_paths", study.gather_edge},
              {"holds", study.AllHold()}};
    };
    return outcome;
  });
}

struct Study {
  std::string_view name, summary;
  int (*run)(int argc, char** argv);
};
constexpr std::array kStudies{
    Study{"optics", "how wrong the optics are over mu_a, against two judges", RunOpticsStudyCommand},
    Study{"sharpness", "how far the forward model is from Monte Carlo beside an edge",
          RunSharpnessStudyCommand},
    Study{"calibration", "how right the calibration is, on random rigs of the optical bench",
          RunCalibrationStudyCommand},
};

void PrintStudies(std::FILE* out) {
  std::fprintf(out, "Usage: dermap study NAME -o DIR [OPTIONS]\n\nStudies:\n");
  for (const Study& study : kStudies)
    std::fprintf(out, "  %-12s %s\n", study.name.data(), study.summary.data());
  std::fprintf(out, "\ndermap study NAME --help tells the options of one.\n");
}

}  // namespace

int RunStudyCommand(int argc, char** argv) {
  const std::string_view name = argc < 2 ? "" : argv[1];
  if (name == "--help" || name == "-h") {
    PrintStudies(stdout);
    return 0;
  }
  for (const Study& study : kStudies) {
    if (study.name == name) return study.run(argc - 1, argv + 1);
  }
  std::fprintf(stderr, "dermap study: error: %s; dermap study --help lists the studies\n",
               name.empty() ? "the name of a study is missing"
                            : ("unknown study '" + std::string(name) + "'").c_str());
  return static_cast<int>(ExitCode::kBadInput);
}

}  // namespace dermap
