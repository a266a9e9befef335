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
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

std::atomic<bool> stop_asked{false};

void AskToStop(int) {
  stop_asked = true;
}

// Where the time went, device by device: what overlaps is counted for each.
std::string DescribeTimeline(const SessionTimeline& timeline) {
  if (timeline.frames.empty()) return "";
  double expose_s = 0.0, fetch_s = 0.0, check_s = 0.0, write_s = 0.0;
  for (const FrameTiming& t : timeline.frames) {
    expose_s += t.expose.seconds();
    fetch_s += t.fetch.seconds();
    check_s += t.check.seconds();
    write_s += t.write.seconds();
  }
  const ChainTimes c = AddUp(timeline);
  char text[400];
  std::snprintf(text, sizeof text,
                "time: camera %.1f s (expose %.1f, fetch %.1f), wheel %.1f s, flash %.1f s, checking %.1f s, "
                "writing %.1f s\n"
                "      %.1f s without the operator, %+.1f %% against the slowest device alone\n",
                c.camera_s, expose_s, fetch_s, c.wheel_s, c.flash_s, check_s, write_s, c.taken_s,
                100.0 * c.overhead());
  return text;
}

nlohmann::json SpanToJson(const TimeSpan& span) {
  return {span.start_s, span.end_s};
}

nlohmann::json TimelineToJson(const SessionTimeline& timeline) {
  nlohmann::json frames = nlohmann::json::array(), waits = nlohmann::json::array();
  for (const FrameTiming& t : timeline.frames) {
    frames.push_back({{"number", t.number},
                      {"good", t.good},
                      {"wheel_s", SpanToJson(t.wheel)},
                      {"flash_s", SpanToJson(t.flash)},
                      {"expose_s", SpanToJson(t.expose)},
                      {"fetch_s", SpanToJson(t.fetch)},
                      {"check_s", SpanToJson(t.check)},
                      {"write_s", SpanToJson(t.write)}});
  }
  for (const TimeSpan& wait : timeline.waits) waits.push_back(SpanToJson(wait));
  const ChainTimes c = AddUp(timeline);
  return {{"frames", frames},     {"operator_s", waits},  {"camera_s", c.camera_s},  {"wheel_s", c.wheel_s},
          {"flash_s", c.flash_s}, {"taken_s", c.taken_s}, {"overhead", c.overhead()}};
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
            {"exposure_changes", summary.session.exposure_changes.size()},
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
  std::filesystem::path timeline;
  command.app().add_option("--timeline", timeline,
                           "Where to draw what each device did when, as an SVG picture");
  return command.Run(argc, argv, [&] {
    std::signal(SIGINT, AskToStop);
    std::signal(SIGTERM, AskToStop);
    options.stop = [] { return stop_asked.load(); };
    options.ask = AskOnTerminal(options.stop);
    ProgressBar bar("capture");
    options.progress = bar.Function();
    const CaptureSummary summary = RunCapture(options);
    if (!timeline.empty()) WriteFileAtomically(timeline, TimelineSvg(summary.timeline));
    return Summarize(summary, options);
  });
}

}  // namespace dermap
