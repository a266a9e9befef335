// SPDX-License-Identifier: Apache-2.0
// Makes the light of a simulated scene by Monte Carlo instead of the forward model: for each band of a rig an
// image of the scene's skin, lit through the window, with its standard error, as a reflectance stack.
#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>

#include "acquire/simulated/patch_reflectance.h"
#include "common/files/stack.h"
#include "tests/reference/monte_carlo.h"

namespace {

using namespace dermap;

// The cells of a plane in which every cell x cell square has one value.
PlaneF Cells(const PlaneF& plane, int cells) {
  PlaneF small(cells, cells);
  const int side = plane.width() / cells;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) small(x, y) = plane(x * side, y * side);
  return small;
}

reference::MonteCarloScene SceneAt(const Scene& scene, const Chromophores& chromophores, double wavelength_nm,
                                   int cells, double window_mm) {
  const TissueConfig& t = scene.tissue;
  const Absorbers absorbers = chromophores.At(wavelength_nm, t);
  reference::MonteCarloScene out;
  out.beam = reference::Beam::kWindow;
  out.width = out.height = cells;
  out.pixel_size_mm = window_mm / cells;
  out.stack = {t.n_outside,
               {{.thickness_mm = t.epidermis_thickness_mm,
                 .mu_s = ReducedScatteringEpidermis(wavelength_nm, t),
                 .n = t.n_epidermis,
                 .absorber_below = t.junction_absorbance},
                {.mu_s = ReducedScatteringDermis(wavelength_nm, t), .n = t.n_dermis}},
               t.n_dermis};
  out.mu_a.assign(2, PlaneF(cells, cells));
  std::array<PlaneF, kParameterCount> small;
  for (int k = 0; k < kParameterCount; ++k) small[k] = Cells(scene.maps.planes[k], cells);
  for (std::size_t i = 0; i < out.mu_a[0].size(); ++i) {
    ParameterVector p;
    for (int k = 0; k < kParameterCount; ++k) p[k] = small[k].data()[i];
    out.mu_a[0].data()[i] = static_cast<float>(absorbers.MuAEpidermis(p));
    out.mu_a[1].data()[i] = static_cast<float>(absorbers.MuADermis(p));
  }
  if (!scene.maps.junction_absorbance.empty())
    out.absorber_below = {Cells(scene.maps.junction_absorbance[0], cells), PlaneF()};
  return out;
}

PlaneF AsFloat(const Plane<double>& plane) {
  PlaneF out(plane.width(), plane.height());
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = static_cast<float>(plane.data()[i]);
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Monte Carlo images of a simulated scene, band by band");
  std::string scene_path, rig_path, output;
  double photons = 4e7;
  int cells = 32;
  reference::MonteCarloOptions options;
  app.add_option("scene", scene_path, "Scene, TOML")->required();
  app.add_option("--rig", rig_path, "Rig: its bands and its window")->required();
  app.add_option("-o,--output", output, "Reflectance stack to write, .exr")->required();
  app.add_option("--cells", cells, "Pixels along a side; the scene's own cells (default 32)");
  app.add_option("--photons", photons, "A band (default 4e7)");
  app.add_option("--seed", options.seed, "Of the first band; the next ones count on (default 1)");
  app.add_option("--threads", options.threads, "Threads (the result is the same for any number)");
  CLI11_PARSE(app, argc, argv);
  try {
    const RigConfig rig = ReadRig(rig_path);
    const Scene scene = ReadScene(scene_path, rig.window_mm);
    const Chromophores chromophores(ConfigDirectory() / "spectra");
    ReflectanceStack stack;
    stack.pixel_size_mm = rig.window_mm / cells;
    stack.notes["source"] = "Monte Carlo, tests/reference";
    stack.notes["photons"] = std::to_string(static_cast<std::uint64_t>(photons)) + " a band";
    stack.notes["seed"] = std::to_string(options.seed);
    options.photons = static_cast<std::uint64_t>(photons);
    for (const Band& band : BandsOfRig(rig)) {
      const auto result =
          RunMonteCarlo(SceneAt(scene, chromophores, band.wavelength_nm, cells, rig.window_mm), options);
      std::cerr << band.wavelength_nm << " nm: " << result.reflectance.value << '\n';
      stack.bands.push_back({band.wavelength_nm, 0.0});
      stack.reflectance.push_back(AsFloat(result.reflectance_image));
      stack.sigma.push_back(AsFloat(result.reflectance_image_error));
      ++options.seed;
    }
    WriteReflectanceStack(output, stack);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
  return 0;
}
