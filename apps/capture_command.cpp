// SPDX-License-Identifier: Apache-2.0
// dermap capture PLAN.toml --rig RIG.toml --out SESSION: one session; or --daemon ADDRESS:PORT --out NAME,
// taken by a daemon.
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "acquire/daemon/daemon_client.h"
#include "acquire/sequence.h"
#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/daemon_address.h"
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
  char text[500];
  std::snprintf(
      text, sizeof text,
      "time: camera %.1f s (expose %.1f, fetch %.1f), wheel %.1f s, flash %.1f s; checking %.1f s, "
      "writing %.1f s\n"
      "      %.1f s without the operator: %+.1f %% against the slowest device alone, %+.1f %% against "
      "devices that wait for each other's exposures (%.1f s)\n",
      c.camera_s, expose_s, fetch_s, c.wheel_s, c.flash_s, check_s, write_s, c.taken_s, 100.0 * c.overhead(),
      100.0 * (c.taken_s / std::max(c.turns_s, 1e-9) - 1.0), c.turns_s);
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
                      {"ready_s", SpanToJson(t.ready)},
                      {"expose_s", SpanToJson(t.expose)},
                      {"fetch_s", SpanToJson(t.fetch)},
                      {"check_s", SpanToJson(t.check)},
                      {"write_s", SpanToJson(t.write)}});
  }
  for (const TimeSpan& wait : timeline.waits) waits.push_back(SpanToJson(wait));
  const ChainTimes c = AddUp(timeline);
  return {{"frames", frames},     {"operator_s", waits},     {"camera_s", c.camera_s},
          {"wheel_s", c.wheel_s}, {"flash_s", c.flash_s},    {"turns_s", c.turns_s},
          {"taken_s", c.taken_s}, {"overhead", c.overhead()}};
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

struct DaemonArguments {
  std::string address;
  std::filesystem::path token_file;
  SubjectForm subject;
};

// Plan and rig are the daemon's.
Outcome CaptureOnDaemon(const CaptureOptions& options, const DaemonArguments& daemon,
                        const std::filesystem::path& timeline) {
  if (!options.plan.empty() || !options.rig.empty() || !options.scene.empty() || !timeline.empty()) {
    throw InputError(
        "--daemon was given with a plan, --rig, --scene or --timeline, which are not for it; remedy: leave "
        "them out");
  }
  RemoteSession session;
  session.daemon = ParseDaemonAddress("--daemon", daemon.address);
  session.daemon.token = ReadDaemonToken(daemon.token_file);
  session.form = {options.out.string(), daemon.subject.subject,     daemon.subject.site,
                  daemon.subject.notes, options.reference.string(), options.resume};
  session.stop = options.stop;
  session.progress = options.progress;
  session.ask = [](const OperatorRequest& request, const std::function<bool()>& over) {
    return AskOnTerminal(over)(request);
  };
  const RemoteSummary summary = RunOnDaemon(session);
  Outcome outcome;
  outcome.code = summary.complete ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
  for (const std::string& warning : summary.warnings) outcome.text += "warning: " + warning + "\n";
  outcome.text += std::to_string(summary.done) + " of " + std::to_string(summary.total) +
                  " frames: session " + options.out.string() + " of the daemon\n";
  if (!summary.complete) outcome.text += "the session is not complete; go on with --resume\n";
  outcome.fill_json = [summary, name = options.out.string()](nlohmann::json& json) {
    json = {{"session", name},
            {"complete", summary.complete},
            {"frames_done", summary.done},
            {"frames_total", summary.total},
            {"warnings", summary.warnings}};
  };
  return outcome;
}

Outcome CaptureHere(CaptureOptions& options, const DaemonArguments& daemon,
                    const std::filesystem::path& timeline) {
  if (options.plan.empty() || options.rig.empty()) {
    throw InputError(std::string(options.plan.empty() ? "PLAN" : "--rig") +
                     " is missing; expected: capture PLAN.toml --rig RIG.toml --out SESSION");
  }
  const SubjectForm& s = daemon.subject;
  if (!daemon.token_file.empty() || !s.subject.empty() || !s.site.empty() || !s.notes.empty()) {
    throw InputError(
        "--token-file, --subject, --site and --notes go with --daemon; remedy: write subject, site and "
        "notes into the plan");
  }
  options.ask = AskOnTerminal(options.stop);
  const CaptureSummary summary = RunCapture(options);
  if (!timeline.empty()) WriteFileAtomically(timeline, TimelineSvg(summary.timeline));
  return Summarize(summary, options);
}

}  // namespace

int RunCaptureCommand(int argc, char** argv) {
  CommandLine command("capture", "Take one session: black, Spectralon and skin frames for every filter.");
  CaptureOptions options;
  DaemonArguments daemon;
  std::filesystem::path timeline;
  CLI::App& app = command.app();
  app.add_option("PLAN", options.plan, "plan.toml: exposure and ISO for every filter");
  app.add_option("--rig", options.rig, "rig.toml: camera, wheel, filters, references");
  app.add_option("-o,--out", options.out, "The session folder to write; with --daemon its name")->required();
  app.add_flag("--resume", options.resume, "Go on with a session that was interrupted");
  app.add_option("--scene", options.scene, "For simulated devices: a scene TOML instead of the rig's");
  app.add_option("--reference", options.reference,
                 "An earlier session whose black and Spectralon frames are taken over");
  app.add_option("--timeline", timeline, "Where to draw what each device did when, as an SVG picture");
  app.add_option("--daemon", daemon.address,
                 "ADDRESS:PORT of a daemon ('dermap serve') that takes the session");
  app.add_option("--token-file", daemon.token_file, "With --daemon: a file with its token");
  app.add_option("--subject", daemon.subject.subject, "With --daemon: the subject's code, never a name");
  app.add_option("--site", daemon.subject.site, "With --daemon: where on the body");
  app.add_option("--notes", daemon.subject.notes, "With --daemon: notes");
  return command.Run(argc, argv, [&] {
    std::signal(SIGINT, AskToStop);
    std::signal(SIGTERM, AskToStop);
    options.stop = [] { return stop_asked.load(); };
    ProgressBar bar("capture");
    options.progress = bar.Function();
    return daemon.address.empty() ? CaptureHere(options, daemon, timeline)
                                  : CaptureOnDaemon(options, daemon, timeline);
  });
}

}  // namespace dermap
