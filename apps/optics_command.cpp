// SPDX-License-Identifier: Apache-2.0
// dermap optics GRID.csv -o OUT.csv: reflectance and transmittance of homogeneous skin, row by row.
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/optics_grid.h"
#include "common/files/tissue_config.h"

namespace dermap {
namespace {

struct OpticsArguments {
  std::filesystem::path grid, output, config;
  std::string radii;
  SkinRequest request;
};

TissueConfig TissueOf(const OpticsArguments& args) {
  if (!args.config.empty()) return ReadTissueConfig(args.config);
  TissueConfig config;
  config.junction_absorbance = 0.0;  // a grid says itself what lies between its layers
  return config;
}

Outcome RunOptics(OpticsArguments args) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<TypedRadius> radii;
  if (!args.radii.empty()) radii = ParseRadii(args.radii);
  for (const TypedRadius& radius : radii) args.request.radii_mm.push_back(radius.radius_mm);
  const TissueConfig config = TissueOf(args);
  const HomogeneousSkin skin(args.request, config);
  const OpticsGrid grid = ReadOpticsGrid(args.grid, config);
  ProgressBar bar("optics");
  const auto responses = skin.Evaluate(grid.rows, bar.Function());
  WriteOpticsGrid(args.output, grid, responses, radii, args.request);

  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  Outcome outcome;
  char line[100];
  std::snprintf(line, sizeof line, "%zu rows in %.1f s: ", responses.size(), seconds);
  outcome.text = line + args.output.string() + "\n";
  outcome.fill_json = [output = args.output.string(), profiles = args.request.profiles,
                       rows = responses.size(), seconds](nlohmann::json& json) {
    json = {{"output", output}, {"rows", rows}, {"profiles", profiles}, {"seconds", seconds}};
  };
  return outcome;
}

}  // namespace

int RunOpticsCommand(int argc, char** argv) {
  CommandLine command("optics", "Total reflectance and transmittance of homogeneous skin, row by row.");
  OpticsArguments args;
  CLI::App& app = command.app();
  app.add_option("GRID", args.grid, "CSV, one skin a row: docs/formats.md has the columns")->required();
  app.add_option("-o,--output", args.output, "The CSV to write")->required();
  app.add_option("--profiles", args.request.profiles, "exact (default) | multipole | multipole-symmetric");
  app.add_option("--config", args.config, "TOML with a [tissue] table");
  app.add_option("--radial-mm", args.radii, "Add R(r) in 1/mm^2 at these radii, such as 0.03,0.1,0.5");
  app.add_option("--thin-dermis-mm", args.request.thin_dermis_mm,
                 "Add a thin part (an ear): epidermis, dermis of this thickness, epidermis")
      ->check(Within(0.001, 100.0));
  app.add_flag("--single", args.request.single,
               "Add the part of the reflectance that was scattered exactly once");
  return command.Run(argc, argv, [&] { return RunOptics(args); });
}

}  // namespace dermap
