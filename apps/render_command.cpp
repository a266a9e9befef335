// SPDX-License-Identifier: Apache-2.0
// dermap render MAPS.exr -o OUT.exr: maps rendered again, under other light or with other chromophores.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/atomic_file.h"
#include "common/files/choice_record.h"
#include "common/files/tissue_config.h"
#include "render/render.h"

namespace dermap {
namespace {

struct RenderArguments {
  std::filesystem::path maps;
  std::filesystem::path output;
  std::filesystem::path config;
  std::string engine{EngineName(ForwardOptions{}.engine)};
  std::string beneath_tape{NameOf(BeneathTape::kEdge)};
  double pixel_size_mm = 0.0;
  RenderOptions options;
};

void AddOptions(CLI::App& app, RenderArguments& args) {
  app.add_option("MAPS", args.maps, "maps.exr of a fit")->required();
  app.add_option("-o,--output", args.output, "OUT.exr (or .hdr); the sRGB picture OUT.png comes beside it")
      ->required();
  app.add_option(
      "--light", args.options.light,
      "uniform (default) | stripes:PERIODmm | spot:DIAMETERmm | LIGHT.exr: relative irradiance on the patch");
  app.add_option("--edit", args.options.edits, "Change a map first, such as 'C_hd*=0.4'; may be given again")
      ->allow_extra_args(false);
  app.add_option("--wavelengths-nm", args.options.wavelengths_nm,
                 "Such as 450,500,550 (default: the maps' bands)")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--profiles", args.options.profiles,
                 "Source of the profiles (default " + args.options.profiles + ")");
  app.add_option("--engine", args.engine, "lowrank | pyramid | cascade (default " + args.engine + ")");
  app.add_option("--tolerance", args.options.forward.tolerance,
                 "How far the render may be off, relative, rms (default 0.001; engine lowrank)")
      ->check(Within(1e-6, 0.1));
  app.add_option("--beneath-tape", args.beneath_tape,
                 "Skin there: edge (default: as at the window's edge) | mirrored | mean");
  app.add_option("--config", args.config, "TOML with a [tissue] table");
  app.add_option("--pixel-size-mm", args.pixel_size_mm, "Instead of the maps' own")
      ->check(Within(1e-4, 100.0));
}

Outcome Summarize(const RenderResult& result, const std::filesystem::path& path) {
  std::filesystem::path picture = path;
  picture.replace_extension(".png");
  Outcome outcome;
  for (const std::string& note : result.notes) outcome.text += note + "\n";
  char line[120];
  std::snprintf(line, sizeof line, "rendered %d x %d pixels, %zu bands in %.2f s\n", result.image.width(),
                result.image.height(), result.image.bands.size(), result.seconds);
  outcome.text += line + path.string() + "\n" + picture.string() + "\n";
  outcome.fill_json = [result, path, picture](nlohmann::json& json) {
    json = {{"image", path.string()},
            {"picture", picture.string()},
            {"seconds", result.seconds},
            {"notes", result.notes},
            {"forward", ChoiceRecord(result.forward, result.image.bands)}};
  };
  return outcome;
}

}  // namespace

int RunRenderCommand(int argc, char** argv) {
  CommandLine command("render",
                      "Render maps again: under other light, with other chromophores, at other wavelengths.");
  RenderArguments args;
  AddOptions(command.app(), args);
  return command.Run(argc, argv, [&] {
    args.options.forward.engine = EngineFromName(args.engine);
    args.options.forward.beneath_tape = BeneathTapeFromName(args.beneath_tape);
    if (!args.config.empty()) args.options.tissue = ReadTissueConfig(args.config);
    if (args.pixel_size_mm > 0.0) args.options.pixel_size_mm = args.pixel_size_mm;
    const MapsFile maps = ReadMaps(args.maps);
    const std::filesystem::path spectra = ConfigDirectory() / "spectra";
    ProgressBar bar("render");
    const RenderResult result =
        RenderMaps(maps, args.options, Chromophores(spectra), spectra, bar.Function());
    FileBatch files;  // image and picture, or neither
    WriteRender(args.output, result);
    files.Commit();
    return Summarize(result, args.output);
  });
}

}  // namespace dermap
