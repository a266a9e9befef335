// SPDX-License-Identifier: Apache-2.0
// Features as closed forms of the position, so that they are the same at every size.
#include "studies/study_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "acquire/simulated/scene.h"
#include "common/core/error.h"
#include "common/files/picture.h"

namespace dermap {
namespace {

// Centre and radius of freckles, mm.
constexpr std::array<std::array<double, 3>, 6> kFreckles{
    {{1.6, 1.7, 0.55}, {4.9, 1.3, 0.4}, {3.4, 3.6, 0.8}, {6.1, 4.4, 0.5}, {1.5, 5.6, 0.45}, {4.6, 6.2, 0.6}}};

double FreckleShare(double x, double y, double edge_mm) {
  double share = 0.0;
  for (const auto& [cx, cy, radius] : kFreckles)
    share = std::max(share, Rise(radius - std::hypot(x - cx, y - cy), edge_mm));
  return share;
}

// Slow waves of a few per cent in everything, as skin has.
ParameterVector Ground(double melanin, double x, double y) {
  const double wave = std::sin(0.9 * x + 0.4) * std::cos(0.8 * y), other = std::cos(0.7 * x - 0.9 * y);
  return {melanin * (1.0 + 0.06 * wave), 0.65 + 0.03 * other, 0.005 * (1.0 + 0.1 * other),
          0.010 + 0.001 * wave, 0.030 * (1.0 + 0.1 * wave)};
}

ParameterMaps Fill(int size, const std::function<ParameterVector(double x_mm, double y_mm)>& skin) {
  ParameterMaps maps(size, size, AverageSkin());
  const double pixel_mm = kStudyPatch_mm / size;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const ParameterVector p = skin((x + 0.5) * pixel_mm, (y + 0.5) * pixel_mm);
      for (int k = 0; k < kParameterCount; ++k) maps.planes[k](x, y) = static_cast<float>(p[k]);
    }
  return maps;
}

// How deep inside a line across the patch a point lies, mm.
double InsideLine(double x, double y, double half_width_mm) {
  return half_width_mm - std::abs(y - 3.75 - 0.25 * (x - 3.75)) / std::hypot(1.0, 0.25);
}

ParameterMaps Tattoo(int size) {
  ParameterMaps maps = Fill(size, [](double x, double y) { return Ground(0.04, x, y); });
  PlaneF& ink = maps.junction_absorbance.emplace_back(size, size);
  const double pixel_mm = kStudyPatch_mm / size;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      ink(x, y) =
          static_cast<float>(TissueConfig{}.junction_absorbance +
                             0.6 * Rise(InsideLine((x + 0.5) * pixel_mm, (y + 0.5) * pixel_mm, 0.5), 0.1));
  return maps;
}

}  // namespace

// 10 to 90 % are 2.563 standard deviations.
double Rise(double inside_mm, double edge_mm) {
  return edge_mm > 0.0 ? 0.5 * std::erfc(-inside_mm / (edge_mm / 2.563 * std::sqrt(2.0)))
                       : (inside_mm > 0.0 ? 1.0 : 0.0);
}

std::vector<Band> StudyBands() {
  std::vector<Band> bands;
  for (const double wavelength_nm : {450., 480., 510., 540., 560., 580., 610., 650.})
    bands.push_back({wavelength_nm, 0.0});
  return bands;
}

ParameterMaps FreckledSkin(int size, double base, double contrast, double edge_mm) {
  return Fill(size, [&](double x, double y) {
    ParameterVector p = Ground(base, x, y);
    const double share = FreckleShare(x, y, edge_mm);
    p[static_cast<int>(Parameter::kC_m)] =
        std::min(0.5, p[static_cast<int>(Parameter::kC_m)] * (1.0 + (contrast - 1.0) * share));
    p[static_cast<int>(Parameter::kBeta_m)] -= 0.12 * share * std::min(1.0, contrast - 1.0);
    return p;
  });
}

ParameterMaps StudySkin(const std::string& name, int size) {
  if (name == "light") return FreckledSkin(size, 0.025, 3.0, 0.3);
  if (name == "medium") return FreckledSkin(size, 0.06, 2.0, 0.3);
  if (name == "dark") return FreckledSkin(size, 0.3, 1.4, 0.3);
  if (name == "tattoo") return Tattoo(size);
  if (name == "vein")
    return Fill(size, [](double x, double y) {
      ParameterVector p = Ground(0.05, x, y);
      p[static_cast<int>(Parameter::kC_hd)] += 0.05 * Rise(InsideLine(x, y, 0.5), 0.6);
      return p;
    });
  if (name == "step")
    return Fill(size, [](double x, double y) {
      ParameterVector p = Ground(0.05, x, y);
      p[static_cast<int>(Parameter::kC_m)] += 0.25 * Rise(x - 3.75, 0.0);
      return p;
    });
  const auto file = ConfigDirectory() / "scenes" / (name + ".toml");
  if (!std::filesystem::exists(file))
    throw InputError(
        fmt::format("'{}' is no scene of the studies; expected light, medium, dark, vein, step, "
                    "tattoo or a file of config/scenes",
                    name));
  return AverageTo(ReadScene(file, kStudyPatch_mm).maps, size);
}

ReflectanceStack MonteCarloStack() {
  return ReadReflectanceStack(ConfigDirectory() / "scenes" / "monte_carlo_skin.exr");
}

ReflectanceStack NoisyStack(const ForwardModel& model, const std::vector<PlaneF>& reflectance,
                            double relative, std::uint64_t seed) {
  ReflectanceStack stack;
  for (const BandOptics& band : model.optics()) stack.bands.push_back(band.band);
  stack.pixel_size_mm = model.conditions().pixel_size_mm;
  stack.illumination = model.conditions().illumination;
  stack.tape = model.conditions().tape;
  stack.geometry = model.conditions().geometry;
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  for (const PlaneF& plane : reflectance) {
    PlaneF noisy = plane, sigma = plane;
    for (std::size_t i = 0; i < plane.size(); ++i) {
      sigma.data()[i] = static_cast<float>(relative * plane.data()[i]);
      noisy.data()[i] = static_cast<float>(plane.data()[i] + sigma.data()[i] * normal(generator));
    }
    stack.reflectance.push_back(std::move(noisy));
    stack.sigma.push_back(std::move(sigma));
  }
  return stack;
}

PlaneF AverageTo(const PlaneF& plane, int size) {
  return plane.width() == size ? plane : ResizeByArea(plane, size, size);
}

ParameterMaps AverageTo(const ParameterMaps& maps, int size) {
  ParameterMaps small;
  for (int k = 0; k < kParameterCount; ++k) small.planes[k] = AverageTo(maps.planes[k], size);
  for (const PlaneF& plane : maps.junction_absorbance)
    small.junction_absorbance.push_back(AverageTo(plane, size));
  return small;
}

}  // namespace dermap
