// SPDX-License-Identifier: Apache-2.0
// Scenes for the transport tests.
#include "tests/common/transport/scenes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace dermap {

const Chromophores& TestChromophores() {
  static const Chromophores chromophores(ConfigDirectory() / "spectra");
  return chromophores;
}

const ProfileSource& TestSource(const std::string& name) {
  static std::map<std::string, std::unique_ptr<ProfileSource>> sources;
  std::unique_ptr<ProfileSource>& source = sources[name];
  if (!source) source = MakeProfileSource(name);
  return *source;
}

const BandTables& TestTables(double wavelength_nm, const std::string& source) {
  static std::map<std::pair<double, std::string>, BandTables> tables;
  const auto key = std::pair(wavelength_nm, source);
  const auto found = tables.find(key);
  if (found != tables.end()) return found->second;
  return tables[key] = BuildBandTables(TestSource(source), wavelength_nm, TissueConfig{});
}

ImagingConditions Conditions(int size, Illumination illumination) {
  ImagingConditions conditions;
  conditions.pixel_size_mm = 7.5 / size;
  conditions.illumination = illumination;
  return conditions;
}

ForwardModel Model(std::span<const Band> bands, const ImagingConditions& conditions,
                   const ForwardOptions& options, const std::string& source) {
  return ForwardModel(TestChromophores(), TestSource(source), TissueConfig{}, bands, conditions, options);
}

ParameterMaps FreckledSkin(int size, std::uint32_t seed) {
  ParameterVector base = AverageSkin();
  base[static_cast<int>(Parameter::kC_m)] = 0.03;
  ParameterMaps maps(size, size, base);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const double scale = size / 256.0;
  for (int spot = 0; spot < 30; ++spot) {
    const double x0 = share(random) * size, y0 = share(random) * size,
                 radius = (3.0 + 12.0 * share(random)) * scale;
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double distance = std::hypot(x + 0.5 - x0, y + 0.5 - y0);
        const auto disc = [&](double r, double softness) {
          return static_cast<float>(0.5 - 0.5 * std::tanh((distance - r) / (softness * scale)));
        };
        maps[Parameter::kC_m](x, y) += 0.08f * disc(radius, 2.0);
        maps[Parameter::kC_hd](x, y) += 0.01f * disc(2.0 * radius, 6.0);
      }
    }
  }
  return maps;
}

PlaneF Noise(int width, int height, std::uint32_t seed, float low, float high) {
  PlaneF plane(width, height);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  for (float& v : plane.values()) v = value(random);
  return plane;
}

Difference Compare(const PlaneF& found, const PlaneF& reference) {
  double squares = 0.0, largest = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double difference = static_cast<double>(found.data()[i]) - reference.data()[i];
    squares += difference * difference;
    largest = std::max(largest, std::abs(difference));
    mean += reference.data()[i];
  }
  mean /= static_cast<double>(found.size());
  return {std::sqrt(squares / static_cast<double>(found.size())) / mean, largest / mean};
}

}  // namespace dermap
