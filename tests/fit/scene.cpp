// SPDX-License-Identifier: Apache-2.0
// Simulated patches.
#include "tests/fit/scene.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace dermap::testing {

const Chromophores& TestChromophores() {
  static const Chromophores chromophores(ConfigDirectory() / "spectra");
  return chromophores;
}

ForwardModel MakeModel(const std::vector<Band>& bands, const ImagingConditions& conditions) {
  const auto source = MakeProfileSource("exact");
  ForwardOptions options;
  options.tolerance = 1e-5;  // as descent's, which takes differences of renders
  return ForwardModel(TestChromophores(), *source, TissueConfig{}, bands, conditions, options);
}

std::vector<Band> EightBands() {
  return {{450, 0}, {480, 0}, {510, 0}, {540, 0}, {560, 0}, {580, 0}, {610, 0}, {650, 0}};
}

std::vector<Band> FourBands() {
  return {{450, 0}, {510, 0}, {560, 0}, {650, 0}};
}

ImagingConditions Window(double pixel_size_mm) {
  return {pixel_size_mm, Illumination::kWindow, Tape::kFree, Geometry::kFactor0_30};
}

ImagingConditions Uniform(double pixel_size_mm) {
  return {pixel_size_mm, Illumination::kUniform, Tape::kFree, Geometry::kHemispherical};
}

ParameterMaps SpottedSkin(int size, double melanin) {
  ParameterMaps maps(size, size, AverageSkin());
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double u = (x + 0.5) / size, v = (y + 0.5) / size;
      const double spot = std::exp(-std::pow(std::hypot(u - 0.6, v - 0.4) / 0.12, 4));
      maps[Parameter::kC_m](x, y) = static_cast<float>(melanin * (1 + 0.2 * std::sin(5 * u)) + 0.06 * spot);
      maps[Parameter::kBeta_m](x, y) = static_cast<float>(0.62 + 0.06 * std::sin(4 * v));
      maps[Parameter::kC_he](x, y) =
          static_cast<float>(0.005 * (1 + 0.3 * std::sin(6 * u) * std::cos(5 * v)));
      maps[Parameter::kC_bc](x, y) = static_cast<float>(0.01 * (1 + 0.2 * std::cos(4 * u)));
      maps[Parameter::kC_hd](x, y) = static_cast<float>(0.03 * (1 + 0.3 * std::cos(4 * u + 3 * v)));
    }
  }
  return maps;
}

ReflectanceStack NoisyStack(const ForwardModel& model, const ParameterMaps& maps, double relative_noise,
                            std::uint64_t seed) {
  ReflectanceStack stack;
  for (const BandOptics& optics : model.optics()) stack.bands.push_back(optics.band);
  stack.reflectance = model.Render(maps);
  stack.pixel_size_mm = model.conditions().pixel_size_mm;
  stack.illumination = model.conditions().illumination;
  stack.tape = model.conditions().tape;
  stack.geometry = model.conditions().geometry;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (PlaneF& plane : stack.reflectance) {
    PlaneF& sigma = stack.sigma.emplace_back(plane.width(), plane.height());
    for (std::size_t i = 0; i < plane.size(); ++i) {
      sigma.data()[i] = static_cast<float>(relative_noise * plane.data()[i]);
      plane.data()[i] += static_cast<float>(sigma.data()[i] * normal(random));
    }
  }
  return stack;
}

FitData Prepared(const ReflectanceStack& stack, int free_count) {
  std::vector<std::string> decisions;
  return PrepareStack(stack, FitOptions{}, free_count, decisions);
}

std::vector<Parameter> AllParameters() {
  return {Parameter::kC_m, Parameter::kBeta_m, Parameter::kC_he, Parameter::kC_bc, Parameter::kC_hd};
}

double MedianRelativeError(const PlaneF& found, const PlaneF& truth) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i)
    errors.push_back(std::abs(found.data()[i] - truth.data()[i]) / truth.data()[i]);
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

}  // namespace dermap::testing
