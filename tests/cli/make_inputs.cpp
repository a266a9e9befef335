// SPDX-License-Identifier: Apache-2.0
// Makes the stacks and maps that the command-line tests feed to dermap, good and bad. Usage: make_inputs DIR
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "common/files/atomic_file.h"
#include "common/files/maps.h"
#include "common/files/stack.h"

namespace dermap {
namespace {

constexpr int kSize = 16, kLargeSize = 160;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Smooth values of the size that skin has; what a fit makes of them is not asked here.
ReflectanceStack GoodStack(std::vector<double> wavelengths_nm) {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0f, 0.002f);
  ReflectanceStack stack;
  for (const double wavelength_nm : wavelengths_nm) {
    stack.bands.push_back({wavelength_nm, 10.0});
    const float level = static_cast<float>(0.25 + 0.35 * (wavelength_nm - 450.0) / 200.0);
    PlaneF& plane = stack.reflectance.emplace_back(kSize, kSize);
    for (float& value : plane.values()) value = level + noise(random);
    stack.sigma.emplace_back(kSize, kSize, 0.002f);
  }
  stack.pixel_size_mm = 0.3;
  return stack;
}

void Fill(ReflectanceStack& stack, float value) {
  for (PlaneF& plane : stack.reflectance) {
    for (float& v : plane.values()) v = value;
  }
}

void MakeInputs(const std::filesystem::path& folder) {
  const std::vector<double> eight{450, 480, 510, 540, 560, 580, 610, 650};
  ReflectanceStack stack = GoodStack(eight);
  WriteReflectanceStack(folder / "good.exr", stack);
  WriteReflectanceStack(folder / "good.hdr", stack);
  const std::string whole = ReadTextFile(folder / "good.exr");
  std::ofstream(folder / "truncated.exr", std::ios::binary) << whole.substr(0, whole.size() / 2);
  WriteReflectanceStack(folder / "one_band.exr", GoodStack({540}));

  stack = GoodStack(eight);
  stack.pixel_size_mm.reset();
  WriteReflectanceStack(folder / "no_pixel_size.exr", stack);
  for (std::size_t band = 0; band < stack.bands.size(); ++band) stack.reflectance[band](3, 4) = kNan;
  stack.pixel_size_mm = 0.3;
  stack.reflectance[2](7, 7) = kNan;
  WriteReflectanceStack(folder / "some_nan.exr", stack);
  Fill(stack, kNan);
  WriteReflectanceStack(folder / "all_nan.exr", stack);
  Fill(stack, 45.0f);
  WriteReflectanceStack(folder / "per_cent.exr", stack);

  MapsFile maps;
  maps.maps = ParameterMaps(kSize, kSize, AverageSkin());
  maps.bands = {{450.0, 10.0}, {600.0, 10.0}};
  maps.pixel_size_mm = 0.3;
  WriteMaps(folder / "maps.exr", maps);

  // Large enough that a fit takes its time.
  maps.maps = ParameterMaps(kLargeSize, kLargeSize, AverageSkin());
  maps.pixel_size_mm = 7.5 / kLargeSize;
  for (int y = 0; y < kLargeSize; ++y)
    for (int x = 0; x < kLargeSize; ++x)
      maps.maps[Parameter::kC_m](x, y) =
          static_cast<float>(0.08 + 0.04 * std::sin(0.1 * x) * std::cos(0.07 * y));
  WriteMaps(folder / "large_maps.exr", maps);
}

}  // namespace
}  // namespace dermap

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_inputs DIR\n");
    return 2;
  }
  try {
    dermap::MakeInputs(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_inputs: %s\n", error.what());
    return 1;
  }
}
