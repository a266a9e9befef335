// SPDX-License-Identifier: Apache-2.0
// dermap fit SPECTRA.csv -o DIR: the parameters of each measured spectrum, without lateral transport.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/atomic_file.h"
#include "common/files/csv_table.h"
#include "common/files/text.h"
#include "common/files/tissue_config.h"
#include "fit/spectra/fit_spectra.h"
#include "fit/spectra/write_spectra.h"

namespace dermap {
namespace {

constexpr std::size_t kPrinted = 20;  // spectra; all are in spectra.csv

struct FitSpectraArguments {
  std::filesystem::path input, output, config;
  std::string noise, aperture, range;
  bool pixels = false;  // said by --spectra; MeansSpectra has looked for it already
  SpectraFormat format;
  SpectraOptions options;
};

bool IsTable(std::string_view name) {
  return LowerCase(std::filesystem::path(name).extension().string()) == ".csv";
}

// "8,11" or "8": one or two numbers.
std::pair<double, double> OneOrTwo(const std::string& flag, const std::string& text, double second) {
  const std::size_t comma = std::min(text.find(','), text.size());
  const double first = CsvNumber(flag, "the first number", Trim(std::string_view(text).substr(0, comma)));
  if (comma == text.size()) return {first, second};
  return {first, CsvNumber(flag, "the second number", Trim(std::string_view(text).substr(comma + 1)))};
}

void AddOptions(CLI::App& app, FitSpectraArguments& args) {
  app.add_option("SPECTRA", args.input, "CSV, one spectrum a row; or a stack, each pixel a spectrum")
      ->required();
  app.add_option("-o,--output", args.output, "The folder to write")->required();
  app.add_flag("--spectra", args.pixels, "Take a stack's pixels as spectra, without lateral transport");
  app.add_option("--layout", args.format.layout, "auto (default) | rows | columns: where the spectra stand");
  app.add_flag("--percent", args.format.per_cent, "The numbers are per cent");
  app.add_option("--range-nm", args.range, "Wavelengths that are fitted (default 400,720)");
  app.add_option("--fwhm-nm", args.options.instrument.fwhm_nm,
                 "Width of each band (default 10; 0: monochromatic)")
      ->check(Within(0.0, 100.0));
  app.add_option(
      "--aperture-mm", args.aperture,
      "Diameters measured and lit, such as 8,11 (default: so wide that no light is lost beside it)");
  app.add_flag("--specular-included", args.options.instrument.specular_included,
               "The instrument measured the mirror reflection too");
  app.add_option("--noise", args.noise,
                 "Standard deviation of a reflectance: absolute,relative (default 0.001,0)");
  app.add_option("--model", args.options.model, "auto (default: by the evidence), or one model's name");
  app.add_option("--config", args.config, "TOML with a [tissue] table (default: anisotropy 0.8, 0.06 mm)");
}

void Resolve(FitSpectraArguments& args) {
  if (!args.config.empty()) args.options.tissue = ReadTissueConfig(args.config, MeasuredTissue());
  if (!args.noise.empty()) {
    const auto [absolute, relative] = OneOrTwo("--noise", args.noise, 0.0);
    if (absolute < 0.0 || relative < 0.0 || absolute > 1.0 || relative > 1.0 || absolute + relative <= 0.0) {
      throw InputError(
          fmt::format("--noise is {}; expected two numbers from 0 to 1, not both 0.", args.noise));
    }
    args.options.noise = {absolute, relative};
  }
  if (!args.range.empty()) {
    std::tie(args.format.from_nm, args.format.to_nm) = OneOrTwo("--range-nm", args.range, 0.0);
    if (!(args.format.from_nm >= 350.0 && args.format.to_nm <= 1000.0 &&
          args.format.from_nm < args.format.to_nm)) {
      throw InputError(
          fmt::format("--range-nm is {}; expected two ascending wavelengths from 350 to 1000 nm, such "
                      "as 400,720.",
                      args.range));
    }
  }
  if (!args.aperture.empty()) {
    const auto [measured, lit] = OneOrTwo("--aperture-mm", args.aperture, -1.0);
    args.options.instrument.aperture = {0.5 * measured, 0.5 * (lit < 0.0 ? measured : lit)};
    if (!args.options.instrument.aperture.IsFinite()) {
      throw InputError(
          fmt::format("--aperture-mm is {}; expected two diameters from 1 to 100 mm.", args.aperture));
    }
  }
  if (args.options.model != "auto") SkinModelFromName(args.options.model, args.options.tissue);
}

// A stack says itself how wide its bands are and at which angle they were seen.
MeasuredSpectra ReadInput(FitSpectraArguments& args, bool width_is_given) {
  if (IsTable(args.input.string())) return ReadSpectra(args.input, args.format);
  const ReflectanceStack stack = ReadReflectanceStack(args.input);
  args.options.instrument.geometry = stack.geometry;
  if (!width_is_given) {
    args.options.instrument.fwhm_nm = 0.0;
    for (const Band& band : stack.bands) {
      args.options.instrument.fwhm_nm += band.fwhm_nm / static_cast<double>(stack.bands.size());
    }
  }
  return SpectraOfStack(stack, args.format, args.input.string());
}

std::string Line(const SpectraFit& fit, std::size_t i) {
  const ModelFit& best = fit.fits[i].best();
  std::string line = fmt::format("  {:<12} {:<20} rms {:.4f} ",
                                 Shorten(fit.spectra.rows[i].labels.front(), 12), best.model.name, best.rms);
  for (const SkinParameter p : best.model.free) {
    line += fmt::format(" {} {:.3g}", InfoOf(p).name, best.skin[static_cast<int>(p)]);
    const bool at_bound = std::find(best.at_bound.begin(), best.at_bound.end(), p) != best.at_bound.end();
    line += at_bound ? " (bound)" : fmt::format(" +- {:.1g}", best.sigma[static_cast<int>(p)]);
  }
  return line + (best.converged ? "\n" : "  NOT CONVERGED\n");
}

Outcome Summarize(const SpectraFit& fit, const std::filesystem::path& folder) {
  Outcome outcome;
  outcome.code = fit.Converged() ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
  outcome.text = fmt::format("{} spectra, {} wavelengths: median rms {:.4f}, {:.1f} s\n", fit.fits.size(),
                             fit.spectra.wavelengths_nm.size(), fit.MedianRms(), fit.seconds);
  const std::vector<int> counts = fit.ChosenCounts();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0)
      outcome.text += fmt::format("  {:<20} chosen for {}\n", SkinModelNames()[i], counts[i]);
  }
  const std::size_t printed = std::min(kPrinted, fit.fits.size());
  for (std::size_t i = 0; i < printed; ++i) outcome.text += Line(fit, i);
  if (printed < fit.fits.size()) outcome.text += fmt::format("  ... {} more\n", fit.fits.size() - printed);
  outcome.text += (folder / "report.html").string() + "\n";
  outcome.fill_json = [fit, folder](nlohmann::json& json) {
    json = nlohmann::json(SpectraJson(fit, false));
    json["directory"] = folder.string();
  };
  return outcome;
}

}  // namespace

bool MeansSpectra(int argc, char** argv) {
  return std::any_of(argv + 1, argv + argc,
                     [](const char* word) { return std::strcmp(word, "--spectra") == 0 || IsTable(word); });
}

int RunFitSpectraCommand(int argc, char** argv) {
  CommandLine command("fit",
                      "Fit measured spectra of skin, each by itself, and choose the model that it needs.");
  FitSpectraArguments args;
  AddOptions(command.app(), args);
  return command.Run(argc, argv, [&] {
    Resolve(args);
    const Chromophores chromophores(ConfigDirectory() / "spectra");
    MeasuredSpectra spectra = ReadInput(args, command.app().count("--fwhm-nm") > 0);
    ProgressBar bar("fit");
    const SpectraFit fit = FitSpectra(std::move(spectra), args.options, chromophores, bar.Function());
    FileBatch folder;  // all of it, or nothing
    WriteSpectra(args.output, fit, args.input.filename().string());
    folder.Commit();
    return Summarize(fit, args.output);
  });
}

}  // namespace dermap
