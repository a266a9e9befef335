// SPDX-License-Identifier: Apache-2.0
// The program inherits the preload library and the testbed's place. Its questions begin with what they are
// about: "[place skin]", "[turn 3]", "[fault]".
#include "acquire/emulator/operator_at_terminal.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "common/core/error.h"

extern char** environ;

namespace dermap::emulator {
namespace {

std::atomic<pid_t> running_program{-1};

void PassOn(int signal_number) {
  if (running_program > 0) ::kill(running_program, signal_number);
}

void Answer(EmulatedStation& station, const std::string& line, int to_program, double answer_s) {
  const auto about = [&](const char* what) { return line.rfind(what, 0) == 0; };
  if (about("[place black]")) {
    station.Place(FrameRole::kBlack);
  } else if (about("[place spectralon]")) {
    station.Place(FrameRole::kSpectralon);
  } else if (about("[place skin]")) {
    station.Place(FrameRole::kSkin);
  } else if (about("[turn ")) {
    station.TurnWheel(std::atoi(line.c_str() + 6));
  } else if (about("[fault]")) {
    station.SeeToIt();
  } else {
    return;
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(answer_s));
  // A program that has ended in the meantime needs no answer.
  if (::write(to_program, "\n", 1) != 1) return;
}

}  // namespace

int RunWithOperator(EmulatedStation& station, const std::vector<std::string>& command, double answer_s) {
  int in[2], out[2];
  if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) throw DeviceError("no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in[0], 0);
  posix_spawn_file_actions_adddup2(&actions, out[1], 2);
  std::vector<std::string> words = command;
  std::vector<char*> arguments;
  for (std::string& w : words) arguments.push_back(w.data());
  arguments.push_back(nullptr);
  pid_t pid = -1;
  const int error = posix_spawnp(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(in[0]);
  ::close(out[1]);
  if (error != 0) throw InputError("cannot run " + command[0] + ": " + std::strerror(error));
  running_program = pid;
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGINT, PassOn);
  ::signal(SIGTERM, PassOn);

  std::string line;
  char block[4096];
  for (ssize_t size = 0; (size = ::read(out[0], block, sizeof block)) > 0 || (size < 0 && errno == EINTR);) {
    if (size < 0) continue;
    if (::write(2, block, static_cast<std::size_t>(size)) != size) break;
    for (ssize_t i = 0; i < size; ++i) {
      if (block[i] != '\n') {
        line += block[i];
        continue;
      }
      Answer(station, line, in[1], answer_s);
      line.clear();
    }
  }
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  running_program = -1;
  ::close(in[1]);
  ::close(out[0]);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace dermap::emulator
