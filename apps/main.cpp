// SPDX-License-Identifier: Apache-2.0
// dermap: the table of commands.
#include <array>
#include <cstdio>
#include <string_view>

#include "apps/commands.h"
#include "common/core/error.h"
#include "common/core/version.h"

namespace dermap {
namespace {

struct Command {
  std::string_view name;
  std::string_view summary;
  int (*run)(int argc, char** argv);
};

constexpr std::array kCommands{
    Command{"capture", "take one session: black, Spectralon and skin frames for every filter",
            RunCaptureCommand},
    Command{"serve", "run the station for the operator's page and for programs: HTTP on this machine",
            RunServeCommand},
    Command{"devices", "what is attached, by which driver, and what stands in the way", RunDevicesCommand},
    Command{"verify", "check a session: manifest and SHA-256 of every frame", RunVerifyCommand},
    Command{"calibrate", "turn a session's raw frames into an aligned reflectance stack",
            RunCalibrateCommand},
    Command{"import", "bring a calibrated stack of TIFF or ENVI files into our layout", RunImportCommand},
    Command{"fit", "recover the chromophore maps of a reflectance stack", RunFitCommand},
    Command{"render", "render maps again: other light, other chromophores, other wavelengths",
            RunRenderCommand},
    Command{"optics", "total reflectance and transmittance of homogeneous skin, row by row",
            RunOpticsCommand},
    Command{"study", "the charts of how right, fast and stable the methods are", RunStudyCommand},
};

void PrintUsage(std::FILE* out) {
  std::fprintf(out, "dermap %s: from multi-spectral images of skin to maps of its chromophores\n\n",
               kVersion);
  std::fprintf(out, "Usage: dermap COMMAND [OPTIONS]\n\nCommands:\n");
  for (const Command& command : kCommands) {
    std::fprintf(out, "  %-10s %s\n", command.name.data(), command.summary.data());
  }
  std::fprintf(out, "\ndermap COMMAND --help tells the options of one.\n");
}

int Main(int argc, char** argv) {
  if (argc < 2) {
    PrintUsage(stderr);
    return static_cast<int>(ExitCode::kBadInput);
  }
  const std::string_view name = argv[1];
  if (name == "--help" || name == "-h" || name == "help") {
    PrintUsage(stdout);
    return 0;
  }
  if (name == "--version") {
    std::printf("dermap %s\n", kVersion);
    return 0;
  }
  for (const Command& command : kCommands) {
    if (command.name == name) return command.run(argc - 1, argv + 1);
  }
  std::fprintf(stderr, "dermap: error: unknown command '%s'; dermap --help lists the commands\n", argv[1]);
  return static_cast<int>(ExitCode::kBadInput);
}

}  // namespace
}  // namespace dermap

int main(int argc, char** argv) {
  return dermap::Main(argc, argv);
}
