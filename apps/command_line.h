// SPDX-License-Identifier: Apache-2.0
// The frame of every command: parsing, --json, --threads, exit codes, and one sentence for whatever goes
// wrong.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/core/error.h"

namespace dermap {

// What a command did: a few lines for people, one JSON object for programs (--json prints it alone on
// stdout).
struct Outcome {
  ExitCode code = ExitCode::kSuccess;
  std::string text;
  std::function<void(nlohmann::json&)> fill_json;
};

class CommandLine {
 public:
  CommandLine(const std::string& name, const std::string& summary);

  CLI::App& app() { return app_; }
  bool json() const { return json_; }

  // Parses, runs `body`, reports. Returns the process's exit code and never throws.
  int Run(int argc, char** argv, const std::function<Outcome()>& body);

 private:
  int Report(const Outcome& outcome) const;
  int ReportError(ExitCode code, const std::string& message) const;

  CLI::App app_;
  bool json_ = false;
  bool verbose_ = false;
  int threads_ = 0;
};

}  // namespace dermap
