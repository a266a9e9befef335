// SPDX-License-Identifier: Apache-2.0
// The frame of every command.
#include "apps/command_line.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/core/parallel.h"

namespace dermap {
namespace {

// Libraries put line breaks and their own prefixes into messages; a user gets one line.
std::string OneLine(std::string text) {
  for (char& c : text) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace

CommandLine::CommandLine(const std::string& name, const std::string& summary)
    : app_(summary, "dermap " + name) {
  app_.add_flag("--json", json_, "Print one JSON object on stdout instead of text");
  app_.add_flag("-v,--verbose", verbose_, "Log what is being done on stderr");
  app_.add_option("--threads", threads_, "Threads to use (default 0: all cores)")->check(Within(0, 4096));
  app_.footer(
      "Exit codes: 0 done, 1 ran but did not reach its goal, 2 bad usage or input, 3 device, 4 storage.\n"
      "File formats: docs/formats.md");
}

int CommandLine::Run(int argc, char** argv, const std::function<Outcome()>& body) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is then a failed write, reported like a full disk
  std::signal(SIGPIPE, SIG_IGN);
  try {
    app_.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app_.exit(help);
  } catch (const CLI::ParseError& error) {
    return ReportError(ExitCode::kBadInput,
                       std::string(error.what()) + "; see " + app_.get_name() + " --help");
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("dermap"));
  spdlog::set_pattern("%^%l%$: %v");
  spdlog::set_level(verbose_ ? spdlog::level::debug : spdlog::level::warn);
  try {
    std::optional<ThreadLimit> limit;
    if (threads_ > 0) limit.emplace(threads_);
    return Report(body());
  } catch (const Error& error) {
    return ReportError(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return ReportError(ExitCode::kBadInput,
                       "not enough memory for this input; remedy: a smaller image or --size");
  } catch (const std::exception& error) {
    return ReportError(ExitCode::kBadInput, std::string("unexpected failure: ") + error.what());
  }
}

int CommandLine::Report(const Outcome& outcome) const {
  if (json_) {
    nlohmann::json object = nlohmann::json::object();
    if (outcome.fill_json) outcome.fill_json(object);
    object["exit_code"] = static_cast<int>(outcome.code);
    std::printf("%s\n", object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  } else {
    std::fputs(outcome.text.c_str(), stdout);
  }
  if (std::fflush(stdout) != 0) {
    return ReportError(ExitCode::kStorage,
                       "cannot write to standard output; remedy: free space or another target");
  }
  return static_cast<int>(outcome.code);
}

int CommandLine::ReportError(ExitCode code, const std::string& message) const {
  const std::string line = OneLine(message);
  std::fprintf(stderr, "%s: error: %s\n", app_.get_name().c_str(), line.c_str());
  if (json_) {
    const nlohmann::json object{{"error", line}, {"exit_code", static_cast<int>(code)}};
    std::printf("%s\n", object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  }
  return static_cast<int>(code);
}

}  // namespace dermap
