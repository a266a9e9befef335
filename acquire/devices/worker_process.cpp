// SPDX-License-Identifier: Apache-2.0
// Pipes, a deadline on each read, SIGKILL.
#include "acquire/devices/worker_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <system_error>

#include "acquire/devices/device_fault.h"

extern char** environ;

namespace dermap {
namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kLongestLine = 1 << 20;
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

// The environment with another HOME.
std::vector<std::string> EnvironmentWithHome(const fs::path& home) {
  std::vector<std::string> variables{"HOME=" + home.string()};
  for (char** v = environ; *v != nullptr; ++v) {
    if (std::strncmp(*v, "HOME=", 5) != 0) variables.emplace_back(*v);
  }
  return variables;
}

}  // namespace

fs::path FindHelperProgram(const std::string& name) {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  const fs::path beside = self.parent_path() / name;
  if (!error && fs::exists(beside, error)) return beside;
  const fs::path installed = self.parent_path().parent_path() / "libexec" / "dermap" / name;
  if (fs::exists(installed, error)) return installed;
  throw InputError("the helper program " + name + " is neither at " + beside.string() + " nor at " +
                   installed.string() + "; remedy: build or install dermap as a whole");
}

WorkerProcess::WorkerProcess(fs::path program, fs::path home)
    : program_(std::move(program)), home_(std::move(home)) {}

WorkerProcess::~WorkerProcess() {
  Kill();
}

void WorkerProcess::Kill() noexcept {
  if (to_ >= 0) ::close(to_);
  if (from_ >= 0) ::close(from_);
  to_ = from_ = -1;
  read_.clear();
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
}

void WorkerProcess::Start() {
  int in[2], out[2];
  if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) Give("no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in[0], 0);
  posix_spawn_file_actions_adddup2(&actions, out[1], 1);
  // Whatever else is open here is none of its business: it would keep alive what shall end with us.
  posix_spawn_file_actions_addclosefrom_np(&actions, 3);
  // A signal for the terminal's programs (Ctrl-C) is ours to act on, not the worker's.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::vector<std::string> variables = EnvironmentWithHome(home_);
  std::vector<char*> environment;
  for (std::string& v : variables) environment.push_back(v.data());
  environment.push_back(nullptr);
  std::string name = program_.string();
  char* arguments[]{name.data(), nullptr};
  const int error = posix_spawn(&pid_, name.c_str(), &actions, &attributes, arguments, environment.data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  ::close(in[0]);
  ::close(out[1]);
  to_ = in[1];
  from_ = out[0];
  if (error != 0) {
    pid_ = -1;
    Give(std::string("does not start: ") + std::strerror(error));
  }
}

void WorkerProcess::Give(const std::string& why) {
  Kill();
  throw DeviceFault(FaultKind::kNoAnswer, "the camera's helper process " + why +
                                              "; remedy: switch the camera off and on, and go on");
}

void WorkerProcess::ReadMore(SteadyClock::time_point until) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - SteadyClock::now());
  pollfd readable{from_, POLLIN, 0};
  const int ready = left.count() <= 0 ? 0 : ::poll(&readable, 1, static_cast<int>(left.count()));
  if (ready < 0 && errno == EINTR) return;
  if (ready <= 0) Give("says nothing");
  char block[65536];
  const ssize_t size = ::read(from_, block, sizeof block);
  if (size < 0 && errno == EINTR) return;
  if (size <= 0) Give("has ended");
  read_.append(block, static_cast<std::size_t>(size));
}

std::string WorkerProcess::ReadLine(SteadyClock::time_point until) {
  std::size_t end = read_.find('\n');
  while (end == std::string::npos) {
    if (read_.size() > kLongestLine) Give("talks nonsense");
    ReadMore(until);
    end = read_.find('\n');
  }
  std::string line = read_.substr(0, end);
  read_.erase(0, end + 1);
  return line;
}

WorkerAnswer WorkerProcess::Ask(const std::string& request, std::chrono::milliseconds limit) {
  if (pid_ <= 0) Start();
  const auto until = SteadyClock::now() + limit;
  const std::string text = request + "\n";
  // A worker that died makes the write fail; SIGPIPE must not end us.
  signal(SIGPIPE, SIG_IGN);
  if (::write(to_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) Give("has ended");
  WorkerAnswer answer;
  answer.line = ReadLine(until);
  const nlohmann::json line = nlohmann::json::parse(answer.line, nullptr, false);
  if (!line.is_object()) Give("talks nonsense");
  const nlohmann::json bytes = line.value("bytes", nlohmann::json(0u));
  if (!bytes.is_number_unsigned() || bytes > kMostBytes) Give("talks nonsense");
  const auto size = bytes.get<std::size_t>();
  while (read_.size() < size) ReadMore(until);
  const auto* begin = reinterpret_cast<const std::byte*>(read_.data());
  answer.bytes.assign(begin, begin + size);
  read_.erase(0, size);
  return answer;
}

}  // namespace dermap
