// SPDX-License-Identifier: Apache-2.0
// What can go wrong, as exceptions that know the exit code of the program. A message is one sentence (or two)
// that names the file or value, what was found, what was expected and the remedy.
#pragma once

#include <stdexcept>
#include <string>

namespace dermap {

// The documented exit codes of every command.
enum class ExitCode {
  kSuccess = 0,
  kGoalNotReached = 1,  // ran, but a fit did not converge or a session is incomplete
  kBadInput = 2,        // usage, configuration, or a file that is missing, damaged or of the wrong shape
  kDevice = 3,          // a camera or a wheel failed
  kStorage = 4,         // could not write: full, read-only, no permission
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : Error(ExitCode::kBadInput, message) {}
};

class DeviceError : public Error {
 public:
  explicit DeviceError(const std::string& message) : Error(ExitCode::kDevice, message) {}
};

class StorageError : public Error {
 public:
  explicit StorageError(const std::string& message) : Error(ExitCode::kStorage, message) {}
};

}  // namespace dermap
