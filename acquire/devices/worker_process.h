// SPDX-License-Identifier: Apache-2.0
// A child process that answers requests, one JSON line each, with a JSON line and perhaps bytes after it. It
// can be killed at any time: what hangs in it hangs nobody else.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace dermap {

struct WorkerAnswer {
  std::string line;  // a JSON object
  std::vector<std::byte> bytes;
};

class WorkerProcess {
 public:
  // `home`: its HOME, so that settings of the user's other programs play no part.
  WorkerProcess(std::filesystem::path program, std::filesystem::path home);
  ~WorkerProcess();  // kills it

  // Starts it if it does not run. Throws DeviceFault (kNoAnswer) where it dies or says nothing in time; it is
  // dead then. `request` is a JSON object on one line; a number under "bytes" in the answer says how many
  // follow its line.
  WorkerAnswer Ask(const std::string& request, std::chrono::milliseconds limit);
  void Kill() noexcept;
  bool running() const { return pid_ > 0; }
  int pid() const { return pid_; }

 private:
  void Start();
  std::string ReadLine(std::chrono::steady_clock::time_point until);
  void ReadMore(std::chrono::steady_clock::time_point until);
  [[noreturn]] void Give(const std::string& why);

  std::filesystem::path program_, home_;
  int pid_ = -1;
  int to_ = -1, from_ = -1;
  std::string read_;  // of its output, not used yet
};

// A program of ours beside the running one; or installed.
std::filesystem::path FindHelperProgram(const std::string& name);

}  // namespace dermap
