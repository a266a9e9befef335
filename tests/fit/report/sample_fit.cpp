// SPDX-License-Identifier: Apache-2.0
// Makes the fit result that the report's tests show.
#include "tests/fit/report/sample_fit.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/files/picture.h"

namespace dermap {
namespace {

constexpr double kNoise = 0.004;

// Parameters at (u, v), both 0 to 1.
ParameterVector SkinAt(double u, double v) {
  ParameterVector p{0.05, 0.62, 0.005, 0.01, 0.03};
  for (const auto& [x, y, r] :
       {std::array{0.3, 0.28, 0.05}, std::array{0.62, 0.45, 0.08}, std::array{0.5, 0.8, 0.04}}) {
    p[0] += 0.12 * std::exp(-0.5 * ((u - x) * (u - x) + (v - y) * (v - y)) / (r * r));
  }
  const double vein = v - 0.2 - 0.5 * u;
  p[4] += 0.05 * std::exp(-0.5 * vein * vein / (0.06 * 0.06));
  p[1] -= 0.2 * u;
  return p;
}

ParameterMaps MakeMaps(int width, int height) {
  ParameterMaps maps(width, height, ParameterVector{});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const ParameterVector p = SkinAt((x + 0.5) / width, (y + 0.5) / height);
      for (int i = 0; i < kParameterCount; ++i) maps.planes[i](x, y) = static_cast<float>(p[i]);
    }
  }
  return maps;
}

float SomeReflectance(const ParameterMaps& maps, std::size_t pixel, double wavelength_nm) {
  const double melanin = 8.0 * std::pow(550.0 / wavelength_nm, 3.0) * maps[Parameter::kC_m].data()[pixel];
  const double blood = (wavelength_nm < 590.0 ? 14.0 : 1.5) * maps[Parameter::kC_hd].data()[pixel];
  return static_cast<float>(0.62 * std::exp(-melanin - blood));
}

void AddBand(FitResult& fit, const ParameterMaps& truth, double wavelength_nm, std::mt19937& random) {
  std::normal_distribution<float> noise(0.0f, static_cast<float>(kNoise));
  const int width = fit.maps.width(), height = fit.maps.height();
  PlaneF measured(width, height), predicted(width, height), residual(width, height);
  double sum = 0.0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    predicted.data()[i] = SomeReflectance(fit.maps, i, wavelength_nm);
    measured.data()[i] = SomeReflectance(truth, i, wavelength_nm) + noise(random);
    residual.data()[i] = measured.data()[i] - predicted.data()[i];
    sum += residual.data()[i] * residual.data()[i];
  }
  fit.bands.push_back({wavelength_nm, 10.0});
  fit.rms_residual_per_band.push_back(std::sqrt(sum / static_cast<double>(measured.size())));
  fit.measured.push_back(std::move(measured));
  fit.predicted.push_back(std::move(predicted));
  fit.residual.push_back(std::move(residual));
  fit.noise.emplace_back(width, height, static_cast<float>(kNoise));
}

void AddRecord(FitResult& fit) {
  for (int i = 0; i < 40; ++i) {
    const double left = std::exp(-i / 6.0);
    fit.history.push_back({i, 6 * i + 1, 0.3 * i, kNoise * (1.0 + 25.0 * left), 1.02 + 600.0 * left * left});
  }
  fit.rms_residual = fit.history.back().rms_residual;
  fit.chi2 = fit.history.back().chi2;
  fit.seconds = 12.34;
  fit.renders = 235;
  fit.converged = true;
  fit.method = "descent";
  fit.profiles = "multipole";
  fit.engine = "pyramid";
  fit.decisions = {"The fit ran at a reduced size to stay within 60 s.",
                   "C_bc was not freed: \"8 bands\" & 5 parameters < what <b>the data</b> support."};
}

}  // namespace

SampleFit MakeSampleFit(int width, int height, int bands) {
  std::mt19937 random(20240607);
  SampleFit sample;
  sample.truth.maps = MakeMaps(2 * width, 2 * height);
  const ParameterMaps truth = MakeMaps(width, height);
  FitResult& fit = sample.fit;
  fit.conditions.pixel_size_mm = 7.5 / width;
  fit.maps = truth;
  fit.sigma = ParameterMaps(width, height, ParameterVector{});
  fit.free_parameters = {Parameter::kC_m, Parameter::kBeta_m, Parameter::kC_he, Parameter::kC_hd};
  for (const Parameter p : fit.free_parameters) {
    std::normal_distribution<float> error(0.0f, 0.04f);
    for (std::size_t i = 0; i < fit.maps[p].size(); ++i) {
      float& value = fit.maps[p].data()[i];
      fit.sigma[p].data()[i] = 0.04f * value;
      value *= 1.0f + error(random);
    }
  }
  std::fill(fit.maps[Parameter::kC_bc].values().begin(), fit.maps[Parameter::kC_bc].values().end(), 0.01f);
  constexpr double kWavelengths[] = {450, 480, 510, 540, 560, 580, 610, 650};
  for (int band = 0; band < bands; ++band) AddBand(fit, truth, kWavelengths[band], random);
  fit.flags = Plane<std::uint32_t>(width, height);
  fit.chi2_map = PlaneF(width, height, 1.0f);
  for (int y = 0; y < height / 8; ++y) {
    for (int x = 0; x < width / 6; ++x) fit.flags(x, y) = kFlagAtBound;
  }
  if (width > 20) fit.flags(0, 0) = kFlagSaturated;
  for (std::size_t i = 0; i < fit.chi2_map.size(); ++i) {
    fit.chi2_map.data()[i] += 0.3f * std::sin(static_cast<float>(i) * 0.7f);
  }
  AddRecord(fit);
  return sample;
}

}  // namespace dermap
