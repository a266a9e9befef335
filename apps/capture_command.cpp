// SPDX-License-Identifier: Apache-2.0
// dermap capture PLAN.toml --rig RIG.toml --out SESSION: one session.
#include <atomic>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "acquire/sequence.h"
#include "apps/command_line.h"
#include "apps/commands.h"

namespace dermap {
namespace {

std::atomic<bool> stop_asked{false};

void AskToStop(int) {
  stop_asked = true;
}

Outcome Summarize(const CaptureSummary& summary, const CaptureOptions& options) {
  const std::string folder = options.out.string();
  Outcome outcome;
  outcome.code = summary.session.complete ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
  for (const std::string& warning : summary.warnings) outcome.text += "warning: " + warning + "\n";
  char line[200];
  std::snprintf(line, sizeof line, "%d of %d frames (%d taken now) in %.1f s: ", summary.taken + summary.kept,
                summary.total, summary.taken, summary.seconds);
  outcome.text += line + folder + "\n";
  if (!summary.session.complete) outcome.text += "the session is not complete; go on with --resume\n";
  outcome.fill_json = [summary, folder](nlohmann::json& json) {
    json = {{"session", folder},
            {"complete", summary.session.complete},
            {"frames_taken", summary.taken},
            {"frames_kept", summary.kept},
            {"frames_total", summary.total},
            {"seconds", summary.seconds},
            {"warnings", summary.warnings}};
  };
  return outcome;
}

}  // namespace

int RunCaptureCommand(int argc, char** argv) {
  CommandLine command("capture", "Take one session: black, Spectralon and skin frames for every filter.");
  CaptureOptions options;
  command.app().add_option("PLAN", options.plan, "plan.toml: exposure and ISO for every filter")->required();
  command.app().add_option("--rig", options.rig, "rig.toml: camera, wheel, filters, references")->required();
  command.app().add_option("-o,--out", options.out, "The session folder to write")->required();
  command.app().add_flag("--resume", options.resume, "Go on with a session that was interrupted");
  command.app().add_option("--scene", options.scene,
                           "For simulated devices: a scene TOML instead of the rig's");
  return command.Run(argc, argv, [&] {
    std::signal(SIGINT, AskToStop);
    std::signal(SIGTERM, AskToStop);
    options.stop = [] { return stop_asked.load(); };
    ProgressBar bar("capture");
    options.progress = bar.Function();
    return Summarize(RunCapture(options), options);
  });
}

}  // namespace dermap
