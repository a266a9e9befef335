// SPDX-License-Identifier: Apache-2.0
// dermap capture PLAN.toml --rig RIG.toml --out SESSION: one session.
#include <atomic>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "acquire/sequence.h"
#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/terminal_operator.h"

namespace dermap {
namespace {

std::atomic<bool> stop_asked{false};

void AskToStop(int) {
  stop_asked = true;
}

// Where the time went, device by device: what overlaps is counted for each.
std::string DescribeTimeline(const std::vector<FrameTiming>& timeline) {
  FrameTiming sum;
  for (const FrameTiming& t : timeline) {
    sum.wheel_s += t.wheel_s;
    sum.flash_s += t.flash_s;
    sum.expose_s += t.expose_s;
    sum.fetch_s += t.fetch_s;
    sum.check_s += t.check_s;
    sum.write_s += t.write_s;
  }
  char text[200];
  std::snprintf(
      text, sizeof text,
      "time: camera %.1f s (expose %.1f, fetch %.1f), wheel %.1f s, waiting for the flash %.1f s, checking "
      "%.1f s, writing %.1f s\n",
      sum.expose_s + sum.fetch_s, sum.expose_s, sum.fetch_s, sum.wheel_s, sum.flash_s, sum.check_s,
      sum.write_s);
  return timeline.empty() ? "" : text;
}

nlohmann::json TimelineToJson(const std::vector<FrameTiming>& timeline) {
  nlohmann::json list = nlohmann::json::array();
  for (const FrameTiming& t : timeline) {
    list.push_back({{"wheel_s", t.wheel_s},
                    {"flash_s", t.flash_s},
                    {"expose_s", t.expose_s},
                    {"fetch_s", t.fetch_s},
                    {"check_s", t.check_s},
                    {"write_s", t.write_s}});
  }
  return list;
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
  if (summary.from_reference > 0) {
    outcome.text += std::to_string(summary.from_reference) + " frames from the reference session\n";
  }
  outcome.text += DescribeTimeline(summary.timeline);
  if (!summary.session.complete) outcome.text += "the session is not complete; go on with --resume\n";
  outcome.fill_json = [summary, folder](nlohmann::json& json) {
    json = {{"session", folder},
            {"complete", summary.session.complete},
            {"frames_taken", summary.taken},
            {"frames_kept", summary.kept},
            {"frames_total", summary.total},
            {"frames_from_reference", summary.from_reference},
            {"timeline", TimelineToJson(summary.timeline)},
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
  command.app().add_option("--reference", options.reference,
                           "An earlier session whose black and Spectralon frames are taken over");
  return command.Run(argc, argv, [&] {
    std::signal(SIGINT, AskToStop);
    std::signal(SIGTERM, AskToStop);
    options.stop = [] { return stop_asked.load(); };
    options.ask = AskOnTerminal(options.stop);
    ProgressBar bar("capture");
    options.progress = bar.Function();
    return Summarize(RunCapture(options), options);
  });
}

}  // namespace dermap
