// SPDX-License-Identifier: Apache-2.0
// dermap-emulator: runs a command on an emulated station, below the unmodified libgphoto2 and libusb.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "acquire/emulator/operator_at_terminal.h"
#include "common/core/error.h"
#include "common/tissue/tissue.h"

namespace dermap::emulator {
namespace {

int Main(int argc, char** argv) {
  CLI::App app("Runs COMMAND with an emulated EOS camera and filter wheel, and plays the operator.");
  StationOptions options;
  std::filesystem::path rig = ConfigDirectory() / "rigs/emulated_8band.toml";
  std::string scene;
  int port = -1;
  double operator_s = 0.0;
  std::vector<std::string> command;
  app.add_option("--rig", rig,
                 "rig.toml: its slots and its scene are what the wheel holds and the camera sees");
  app.add_option("--scene", scene, "A scene TOML instead of the rig's");
  app.add_option("--wheel", options.wheel, "starlight or thorlabs");
  app.add_option("--network", port, "The camera on this port of 127.0.0.1 (PTP/IP) in place of USB")
      ->check(CLI::Range(0, 65535));
  app.add_option("--operator-s", operator_s, "Seconds that the operator takes to do what is asked for")
      ->check(CLI::Range(0.0, 600.0));
  app.add_flag("--real-time", options.real_time, "As slow as real devices; else as fast as it goes");
  app.add_option("--fault", options.faults,
                 "NAME@COUNT[:SECONDS[xTIMES]], at that press of the shutter or move")
      ->allow_extra_args(false);  // one at a time: else it would swallow the "--" before the command
  app.add_option("command", command, "The command and its arguments, after --")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::kBadInput);
  }
  try {
    options.rig = ReadRig(rig);
    if (!scene.empty()) options.rig.simulated_scene = std::filesystem::absolute(scene);
    if (port >= 0) options.network_port = port;
    EmulatedStation station(options);
    return RunWithOperator(station, command, operator_s);
  } catch (const Error& error) {
    std::fprintf(stderr, "dermap-emulator: error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}

}  // namespace
}  // namespace dermap::emulator

int main(int argc, char** argv) {
  // libumockdev sends its events only where its preload library is.
  const std::string preload = dermap::emulator::kPreloadLibrary;
  const char* set = std::getenv("LD_PRELOAD");
  if (set == nullptr || std::string(set).find(preload) == std::string::npos) {
    setenv("LD_PRELOAD", preload.c_str(), 1);
    execv("/proc/self/exe", argv);
    std::perror("dermap-emulator: cannot start itself again");
    return 1;
  }
  return dermap::emulator::Main(argc, argv);
}
