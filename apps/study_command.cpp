// SPDX-License-Identifier: Apache-2.0
// dermap study NAME -o DIR: the charts that belong to the product, one sub-command each.
#include <array>
#include <cstdio>
#include <string>
#include <string_view>

#include "apps/commands.h"
#include "common/core/error.h"

namespace dermap {
namespace {

struct Study {
  std::string_view name, summary;
  int (*run)(int argc, char** argv);
};
constexpr std::array kStudies{
    Study{"calibration", "how right the calibration is, on random rigs of the optical bench",
          RunCalibrationStudyCommand},
};

void PrintStudies(std::FILE* out) {
  std::fprintf(out, "Usage: dermap study NAME -o DIR [OPTIONS]\n\nStudies:\n");
  for (const Study& study : kStudies)
    std::fprintf(out, "  %-12s %s\n", study.name.data(), study.summary.data());
  std::fprintf(out, "\ndermap study NAME --help tells the options of one.\n");
}

}  // namespace

int RunStudyCommand(int argc, char** argv) {
  const std::string_view name = argc < 2 ? "" : argv[1];
  if (name == "--help" || name == "-h") {
    PrintStudies(stdout);
    return 0;
  }
  for (const Study& study : kStudies) {
    if (study.name == name) return study.run(argc - 1, argv + 1);
  }
  std::fprintf(stderr, "dermap study: error: %s; dermap study --help lists the studies\n",
               name.empty() ? "the name of a study is missing"
                            : ("unknown study '" + std::string(name) + "'").c_str());
  return static_cast<int>(ExitCode::kBadInput);
}

}  // namespace dermap
