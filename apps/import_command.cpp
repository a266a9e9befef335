// SPDX-License-Identifier: Apache-2.0
// dermap import INPUT... -o STACK.exr: stacks that others have calibrated, in our layout.
#include <map>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "calibrate/import_stack.h"

namespace dermap {

int RunImportCommand(int argc, char** argv) {
  CommandLine command("import", "Bring a calibrated stack of TIFF or ENVI files into a reflectance stack.");
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path output;
  ImportOptions options;
  command.app()
      .add_option("INPUT", inputs, "TIFF files (a page, channel or file a band), or one ENVI header or stack")
      ->required();
  command.app().add_option("-o,--output", output, "STACK.exr, or STACK.hdr for ENVI")->required();
  command.app()
      .add_option("--wavelengths-nm", options.wavelengths_nm,
                  "One for each plane, with commas, in the files' order")
      ->delimiter(',');
  command.app()
      .add_option("--fwhm-nm", options.fwhm_nm,
                  "Widths of the bands: one, or one each (default: the file's, or 0)")
      ->delimiter(',');
  command.app().add_option("--scale", options.scale,
                           "Reflectance of one unit (default: integers 1 / their largest value, floats 1)");
  command.app()
      .add_option("--pixel-size-mm", options.pixel_size_mm, "Side of a pixel on the skin")
      ->check(Within(1e-4, 100.0));
  command.app()
      .add_option("--relative-sigma", options.relative_sigma,
                  "Noise as a share of the reflectance (default: none)")
      ->check(Within(1e-6, 10.0));
  const std::map<std::string, Illumination> lights{{"window", Illumination::kWindow},
                                                   {"uniform", Illumination::kUniform}};
  const std::map<std::string, Tape> tapes{{"free", Tape::kFree}, {"black", Tape::kBlack}};
  const std::map<std::string, Geometry> geometries{{"hemispherical", Geometry::kHemispherical},
                                                   {"0/30", Geometry::kFactor0_30}};
  command.app()
      .add_option("--illumination", options.illumination,
                  "window or uniform (default: the file's, or window)")
      ->transform(CLI::CheckedTransformer(lights));
  command.app()
      .add_option("--tape", options.tape, "free or black (default: the file's, or free)")
      ->transform(CLI::CheckedTransformer(tapes));
  command.app()
      .add_option("--geometry", options.geometry,
                  "hemispherical or 0/30 (default: the file's, or hemispherical)")
      ->transform(CLI::CheckedTransformer(geometries));
  return command.Run(argc, argv, [&] {
    const ReflectanceStack stack = ImportStack(inputs, options);
    WriteReflectanceStack(output, stack);
    Outcome outcome;
    outcome.text = std::to_string(stack.bands.size()) + " bands of " +
                   std::to_string(stack.reflectance[0].width()) + "x" +
                   std::to_string(stack.reflectance[0].height()) + " pixels\n" + output.string() + "\n";
    outcome.fill_json = [output, bands = stack.bands.size()](nlohmann::json& json) {
      json = {{"stack", output.string()}, {"bands", bands}};
    };
    return outcome;
  });
}

}  // namespace dermap
