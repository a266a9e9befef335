// SPDX-License-Identifier: Apache-2.0
// A simulated patch of skin (or a test target in its place) and the bench it is seen on: the scene TOML.
// Positions are in mm from the window's top left corner, x to the right and y down.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquire/simulated/bench_config.h"
#include "common/tissue/tissue.h"

namespace dermap {

inline constexpr int kPatchSize_px = 256;  // side of the simulated patch

// A target whose reflectance is the same at all wavelengths, in place of skin; it has no lateral transport,
// so what is calibrated from it can be judged without a model of skin.
struct TestPattern {
  enum class Kind { kFlat, kGradient, kChecker, kSteps };
  Kind kind = Kind::kFlat;
  double low = 0.5;  // flat: the reflectance; gradient: at the left border
  double high = 0.5;
  double period_mm = 1.5;  // checker: side of a field
  // Steps: reflectance of each field, row by row, `columns` in a row.
  std::vector<double> values{};
  int columns = 4;
};

struct Scene {
  std::string name;
  std::filesystem::path file;
  std::uint64_t seed = 1;
  std::string profiles = "exact";  // source of the simulated truth
  TissueConfig tissue;
  ParameterMaps maps;  // empty where a test pattern stands in place of skin
  // A stack that says what the skin reflects (hemispherical, lit through the window), in place of the forward
  // model; empty: the model.
  std::filesystem::path reflectance;
  std::optional<TestPattern> pattern;
  BenchConfig bench;
};

// `window_mm`: side of the window. Throws InputError.
Scene ReadScene(const std::filesystem::path& path, double window_mm);

// Reflectance of the pattern on the patch.
PlaneF RenderPattern(const TestPattern& pattern, double window_mm);

}  // namespace dermap
