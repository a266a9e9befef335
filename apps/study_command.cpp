// SPDX-License-Identifier: Apache-2.0
// dermap study NAME -o DIR: the charts that belong to the product, one sub-command each.
#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/picture.h"
#include "studies/ladder_study.h"
#include "studies/optics_study.h"
#include "studies/orders_study.h"
#include "studies/sharpness_study.h"
#include "studies/stability_study.h"
#include "studies/tradeoff_study.h"
#include "studies/truth_study.h"
#include "studies/verdict.h"

namespace dermap {
namespace {

// What every judged study is asked.
struct Request {
  std::filesystem::path folder;
  bool quick = false;
  std::uint64_t seed = 1;
  std::vector<std::string> sweeps, methods;  // of the stability study; empty: all
};
using Part = std::pair<const char*, std::vector<std::string> Request::*>;  // a flag and what it fills

// The frame of a judged study: `run` does the work, writes its files into the folder and returns what the
// outcome says beyond the verdicts.
struct Judged {
  std::vector<Verdict> verdicts;
  std::string text;
  std::filesystem::path page;
};
int RunJudged(int argc, char** argv, const std::string& name, const char* about, const char* files,
              const std::function<Judged(const Request&, const ProgressFunction&)>& run,
              std::initializer_list<Part> parts = {}) {
  CommandLine command("study " + name, about);
  Request request;
  command.app()
      .add_option("-o,--output", request.folder, "The folder to write " + name + "." + files + " to")
      ->required();
  command.app().add_flag("--quick", request.quick, "Few points and photons: less than two minutes");
  command.app().add_option("--seed", request.seed, "Everything random follows from it (default 1)");
  for (const auto& [flag, names] : parts)
    command.app().add_option(flag, request.*names, "Only these, separated by commas")->delimiter(',');
  return command.Run(argc, argv, [&] {
    ProgressBar bar("study " + name);
    const Judged judged = run(request, bar.Function());
    Outcome outcome;
    outcome.code = AllHold(judged.verdicts) ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
    outcome.text = judged.text;
    for (const Verdict& v : judged.verdicts) {
      outcome.text += (v.holds() ? "holds  " : "FAILS  ") + v.claim + ": " + FormatValue(v.worst) +
                      " (limit " + FormatValue(v.limit) + ")\n";
    }
    outcome.text += judged.page.string() + "\n";
    outcome.fill_json = [judged](nlohmann::json& json) {
      json = {{"page", judged.page.string()}, {"verdicts", VerdictsAsJson(judged.verdicts)}};
    };
    return outcome;
  });
}

int RunOpticsStudyCommand(int argc, char** argv) {
  return RunJudged(
      argc, argv, "optics", "How wrong the optics are over mu_a, against adding-doubling and Monte Carlo.",
      "{csv,json,svg,html}", [](const Request& request, const ProgressFunction& progress) {
        const OpticsStudy study = RunOpticsStudy({.quick = request.quick, .seed = request.seed}, progress);
        WriteOpticsStudy(request.folder, study);
        return Judged{study.verdicts, {}, request.folder / "optics.html"};
      });
}

int RunSharpnessStudyCommand(int argc, char** argv) {
  return RunJudged(
      argc, argv, "sharpness",
      "How far the forward model is from Monte Carlo beside an edge, over the edge's width.",
      "{csv,json,svg}", [](const Request& request, const ProgressFunction& progress) {
        const SharpnessStudy study =
            RunSharpnessStudy({.quick = request.quick, .seed = request.seed}, progress);
        WriteSharpnessStudy(request.folder, study);
        std::string text;
        for (const SharpnessPoint& p : study.points) {
          text += fmt::format(
              "edge {:4.1f} mean free paths wide: reciprocal {:.4f}, gather {:.4f}, as published {:.4f} "
              "(judge's noise {:.4f})\n",
              p.width_per_mean_free_path, p.reciprocal.net, p.gather.net, p.published.net,
              p.reciprocal.noise);
        }
        return Judged{study.verdicts, text, request.folder / "sharpness.svg"};
      });
}

int RunOrdersStudyCommand(int argc, char** argv) {
  return RunJudged(argc, argv, "orders", "How many terms of the inter-scattering series each band needs.",
                   "{csv,json,svg}", [](const Request& request, const ProgressFunction& progress) {
                     const OrdersStudy study = RunOrdersStudy({.quick = request.quick}, progress);
                     WriteOrdersStudy(request.folder, study);
                     std::string text;
                     for (const OrdersStudy::Curve& curve : study.curves)
                       text += fmt::format(
                           "{} skin, {:.0f} nm: 99 % of the light in {} terms; the engine takes {}\n",
                           curve.skin, curve.wavelength_nm, curve.terms_99, curve.automatic_terms);
                     return Judged{study.verdicts, text, request.folder / "orders.svg"};
                   });
}

int RunTradeoffStudyCommand(int argc, char** argv) {
  return RunJudged(
      argc, argv, "tradeoff",
      "Time against error of every way to render and to fit. A run that was broken off goes on where it was.",
      "{csv,json,svg,html}", [](const Request& request, const ProgressFunction& progress) {
        const TradeoffStudy study =
            RunTradeoffStudy(request.folder, {.quick = request.quick, .seed = request.seed}, progress);
        WriteTradeoffStudy(request.folder, study);
        std::vector<Verdict> verdicts = study.verdicts;
        // Patches this small take no longer than their overhead: times tell nothing.
        if (!request.quick) verdicts.insert(verdicts.end(), study.timed.begin(), study.timed.end());
        return Judged{
            verdicts,
            fmt::format("{} points, {} of them from an earlier run\n", study.points.size(), study.resumed),
            request.folder / "tradeoff.html"};
      });
}

int RunLadderStudyCommand(int argc, char** argv) {
  return RunJudged(
      argc, argv, "ladder",
      "How much model scenes from uniform to wild are given, the time that saves and the error it costs.",
      "{csv,json,svg,html}", [](const Request& request, const ProgressFunction& progress) {
        const LadderStudy study =
            RunLadderStudy(request.folder, {.quick = request.quick, .seed = request.seed}, progress);
        WriteLadderStudy(request.folder, study);
        std::string text;
        for (const LadderScene& scene : study.scenes)
          text += fmt::format("{:34} {:24} {:5.1f} times faster, {:.1e} off\n", scene.name,
                              RungsInWords(scene), scene.times_faster, scene.error);
        return Judged{study.verdicts, text, request.folder / "ladder.html"};
      });
}

int RunStabilityStudyCommand(int argc, char** argv) {
  return RunJudged(argc, argv, "stability", "Where each method of fitting breaks, and whether it says so.",
                   "{csv,json,svg,html}",
                   [](const Request& request, const ProgressFunction& progress) {
                     const StabilityStudy study = RunStabilityStudy(request.folder,
                                                                    {.quick = request.quick,
                                                                     .seed = request.seed,
                                                                     .sweeps = request.sweeps,
                                                                     .methods = request.methods},
                                                                    progress);
                     WriteStabilityStudy(request.folder, study);
                     std::string text;
                     for (const StabilityEdge& e : study.edges)
                       text += e.found
                                   ? fmt::format("{}, {}: right at {:g}, wrong at {:g} ({})\n", e.axis,
                                                 e.method, e.inside, e.outside, e.response)
                                   : fmt::format("{}, {}: right up to {:g}\n", e.axis, e.method, e.inside);
                     return Judged{study.verdicts, text, request.folder / "stability.html"};
                   },
                   {{"--sweep", &Request::sweeps}, {"--method", &Request::methods}});
}

int RunTruthStudyCommand(int argc, char** argv) {
  return RunJudged(
      argc, argv, "truth",
      "The default fit on skin that is known: errors over Cramer-Rao's bound, coverage of error bars, and "
      "whether the choice of what is free pays.",
      "{csv,json,svg,html}", [](const Request& request, const ProgressFunction& progress) {
        const TruthStudy study =
            RunTruthStudy(request.folder, {.quick = request.quick, .seed = request.seed}, progress);
        WriteTruthStudy(request.folder, study);
        std::string text;
        for (const TruthPoint& p : study.points)
          if (p.free == "auto")
            text += fmt::format("{:15} {:3} pixels: free {}; errors {:.2f} of all free, {:.2f} of five\n",
                                p.scene, p.size, p.chosen, ErrorRatio(study, p, "all"),
                                ErrorRatio(study, p, "paper"));
        return Judged{study.verdicts, text, request.folder / "truth.html"};
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
    Study{"orders", "how many terms of the inter-scattering series each band needs", RunOrdersStudyCommand},
    Study{"tradeoff", "time against error of every way to render and to fit", RunTradeoffStudyCommand},
    Study{"ladder", "how much model scenes are given, what it saves and what it costs",
          RunLadderStudyCommand},
    Study{"stability", "where each method of fitting breaks, and whether it says so",
          RunStabilityStudyCommand},
    Study{"truth", "how near the fit comes to known skin, and whether its error bars are right",
          RunTruthStudyCommand},
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
