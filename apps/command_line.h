// SPDX-License-Identifier: Apache-2.0
// The frame of every command: parsing, --json, --threads, exit codes, and one sentence for whatever goes
// wrong.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
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

// CLI::Range, which takes "nan" for any number, without that.
template <class T>
CLI::Validator Within(T low, T high) {
  const CLI::Range range(low, high);
  CLI::Validator within = range;
  within.operation([range](std::string& text) {
    const std::string fault = range(text);
    double value = 0.0;
    const bool none = CLI::detail::lexical_cast(text, value) && std::isnan(value);
    return fault.empty() && none ? "Value " + text + " is not a number" : fault;
  });
  return within;
}

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
