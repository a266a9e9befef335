// SPDX-License-Identifier: Apache-2.0
// A strip through the judge and through the forward model.
#include "studies/judged_strip.h"

#include <algorithm>
#include <cmath>

#include "studies/study_scenes.h"
#include "tests/reference/monte_carlo.h"

namespace dermap {
namespace {

constexpr int kHeight = 8;  // rows of the rendered strip, all alike

// The strip and its mirror image side by side, endlessly repeated.
reference::MonteCarloScene SceneOf(const Strip& strip, const Chromophores& chromophores) {
  const TissueConfig tissue;
  const Absorbers absorbers = chromophores.At(strip.wavelength_nm, tissue);
  const double mu_s = ReducedScatteringEpidermis(strip.wavelength_nm, tissue);
  const double mu_s_dermis = ReducedScatteringDermis(strip.wavelength_nm, tissue);
  const int width = static_cast<int>(strip.skin.size());
  reference::MonteCarloScene scene;
  scene.beam = reference::Beam::kWindow;
  scene.periodic = true;
  scene.width = 2 * width;
  scene.height = 1;
  scene.pixel_size_mm = strip.pixel_size_mm;
  scene.stack = {tissue.n_outside,
                 {{.thickness_mm = tissue.epidermis_thickness_mm,
                   .mu_s = mu_s,
                   .n = tissue.n_epidermis,
                   .absorber_below = tissue.junction_absorbance},
                  {.mu_s = mu_s_dermis, .n = tissue.n_dermis}},
                 tissue.n_dermis};
  scene.mu_a.assign(2, PlaneF(2 * width, 1));
  for (int x = 0; x < width; ++x) {
    for (const int at : {x, 2 * width - 1 - x}) {
      scene.mu_a[0](at, 0) = static_cast<float>(absorbers.MuAEpidermis(strip.skin[x]));
      scene.mu_a[1](at, 0) = static_cast<float>(absorbers.MuADermis(strip.skin[x]));
    }
  }
  return scene;
}

}  // namespace

std::vector<ParameterVector> MelaninEdge(double width_mm, double pixel_mm, double beside_mm) {
  const int pixels = 2 * static_cast<int>(std::ceil((beside_mm + width_mm) / pixel_mm));
  std::vector<ParameterVector> skin(pixels, AverageSkin());
  for (int i = 0; i < pixels; ++i)
    skin[i][static_cast<int>(Parameter::kC_m)] =
        0.05 + 0.25 * Rise((i + 0.5 - 0.5 * pixels) * pixel_mm, width_mm);
  return skin;
}

JudgedStrip JudgeStrip(const Strip& strip, const Chromophores& chromophores, std::uint64_t photons,
                       std::uint64_t seed, int threads) {
  const auto result = reference::RunMonteCarlo(SceneOf(strip, chromophores),
                                               {.photons = photons, .seed = seed, .threads = threads});
  JudgedStrip judged;
  const int width = static_cast<int>(strip.skin.size());
  for (int x = 0; x < width; ++x) {  // the strip and its mirror image are two measurements of a pixel
    const int other = 2 * width - 1 - x;
    judged.reflectance.push_back(0.5 * (result.reflectance_image(x, 0) + result.reflectance_image(other, 0)));
    judged.standard_error.push_back(
        0.5 * std::hypot(result.reflectance_image_error(x, 0), result.reflectance_image_error(other, 0)));
  }
  return judged;
}

std::vector<double> RenderStrip(const Strip& strip, const Chromophores& chromophores,
                                const ProfileSource& source, Coupling coupling) {
  const int width = static_cast<int>(strip.skin.size());
  ParameterMaps maps(width, kHeight, AverageSkin());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < width; ++x)
      for (int k = 0; k < kParameterCount; ++k) maps.planes[k](x, y) = static_cast<float>(strip.skin[x][k]);
  ForwardOptions options;
  options.coupling = coupling;
  const Band band[] = {{strip.wavelength_nm, 0.0}};
  const ForwardModel model(chromophores, source, {}, band,
                           {.pixel_size_mm = strip.pixel_size_mm, .illumination = Illumination::kUniform},
                           options);
  const PlaneF rendered = model.RenderBand(0, maps);
  return {rendered.Row(kHeight / 2), rendered.Row(kHeight / 2) + width};
}

StripMisfit Compare(const std::vector<double>& rendered, const JudgedStrip& judge) {
  StripMisfit misfit;
  const auto count = static_cast<double>(rendered.size());
  for (std::size_t x = 0; x < rendered.size(); ++x) {
    const double error = rendered[x] / judge.reflectance[x] - 1.0;
    const double noise = judge.standard_error[x] / judge.reflectance[x];
    misfit.rms += error * error / count;
    misfit.noise += noise * noise / count;
    misfit.worst = std::max(misfit.worst, std::abs(error) - 3.0 * noise);
  }
  misfit.net = std::sqrt(std::max(0.0, misfit.rms - misfit.noise));
  misfit.rms = std::sqrt(misfit.rms);
  misfit.noise = std::sqrt(misfit.noise);
  return misfit;
}

}  // namespace dermap
