// SPDX-License-Identifier: Apache-2.0
// Reading a scene and drawing its maps.
#include "acquire/simulated/scene.h"

#include <algorithm>
#include <numeric>

#include "acquire/simulated/skin_features.h"
#include "common/core/error.h"
#include "common/files/tissue_config.h"
#include "common/optics/profile_source.h"

namespace dermap {
namespace {

constexpr double kLargestAmount = 10.0;  // of what a feature adds; the sum is clamped to table 1

Variation ReadVariation(TomlTable& file, const ParameterInfo& info) {
  Variation v{.value = info.mean};
  auto table = file.Table(std::string(info.name));
  if (!table) return v;
  v.value = table->Number("value", info.mean, info.lower, info.upper);
  v.amplitude = table->Number("amplitude", 0.0, 0.0, info.upper - info.lower);
  v.correlation_mm = table->Number("correlation_mm", v.correlation_mm, 0.05, 100.0);
  table->Finish();
  return v;
}

FreckleField ReadFreckles(TomlTable& table, const std::string& file) {
  FreckleField f;
  f.count = table.RequiredInteger("count", 0, 10000);
  const std::vector<double> radius = table.Numbers("radius_mm", {f.smallest_radius_mm, f.largest_radius_mm});
  if (radius.size() != 2 || radius[0] <= 0.0 || radius[1] < radius[0]) {
    throw InputError(file +
                     ": radius_mm of [[freckle]] must be two numbers, the smallest and the largest radius.");
  }
  f.smallest_radius_mm = radius[0];
  f.largest_radius_mm = radius[1];
  f.edge_mm = table.Number("edge_mm", f.edge_mm, 0.01, 10.0);
  f.C_m = table.Number("C_m", 0.0, -kLargestAmount, kLargestAmount);
  f.beta_m = table.Number("beta_m", 0.0, -1.0, 1.0);
  table.Finish();
  return f;
}

SoftLine ReadLine(TomlTable& table, const std::string& file, const std::string& kind,
                  const std::string& amount_key) {
  SoftLine line;
  const std::vector<double> flat = table.Numbers("points_mm", {});
  if (flat.size() < 4 || flat.size() % 2 != 0) {
    throw InputError(file + ": points_mm of [[" + kind + "]] has " + std::to_string(flat.size()) +
                     " numbers; x and y of at least two points are expected, in mm.");
  }
  for (std::size_t i = 0; i < flat.size(); i += 2) line.points.push_back({flat[i], flat[i + 1]});
  line.width_mm = table.Number("width_mm", line.width_mm, 0.01, 10.0);
  line.edge_mm = table.Number("edge_mm", line.edge_mm, 0.01, 10.0);
  line.amount = table.RequiredNumber(amount_key, -kLargestAmount, kLargestAmount);
  table.Finish();
  return line;
}

void ReadSteps(TomlTable& table, const std::string& name, TestPattern& p) {
  p.values = table.Numbers("values", {});
  p.columns = table.Integer("columns", p.columns, 1, 64);
  table.Finish();
  const bool full = !p.values.empty() && p.values.size() % static_cast<std::size_t>(p.columns) == 0;
  const bool sane =
      std::all_of(p.values.begin(), p.values.end(), [](double v) { return v >= 0.0 && v <= 1.5; });
  if (full && sane) return;
  throw InputError(name + ": [pattern] has " + std::to_string(p.values.size()) + " values in rows of " +
                   std::to_string(p.columns) + "; expected full rows of reflectances from 0 to 1.5.");
}

std::optional<TestPattern> ReadPattern(TomlTable& file, const std::string& name) {
  auto table = file.Table("pattern");
  const double flat = file.Number("flat_reflectance", 0.5, 0.0, 1.5);
  if (file.Has("flat_reflectance")) {
    if (table) throw InputError(name + " has both flat_reflectance and [pattern]; leave one of them out.");
    TestPattern p;
    p.low = p.high = flat;
    return p;
  }
  if (!table) return std::nullopt;
  TestPattern p;
  const std::string kind = table->RequiredString("kind");
  if (kind == "gradient") {
    p.kind = TestPattern::Kind::kGradient;
  } else if (kind == "checker") {
    p.kind = TestPattern::Kind::kChecker;
  } else if (kind == "steps") {
    p.kind = TestPattern::Kind::kSteps;
    ReadSteps(*table, name, p);
    return p;
  } else {
    throw InputError(name + ": kind of [pattern] is \"" + kind +
                     "\"; it must be \"gradient\", \"checker\" or \"steps\".");
  }
  p.low = table->RequiredNumber("low", 0.0, 1.5);
  p.high = table->RequiredNumber("high", 0.0, 1.5);
  p.period_mm = table->Number("period_mm", p.period_mm, 0.05, 100.0);
  table->Finish();
  return p;
}

// Adds all lines of a kind to a map; false where there are none.
bool AddLines(TomlTable& file, const std::string& name, const std::string& kind,
              const std::string& amount_key, double pixel_size_mm, PlaneF& plane) {
  PlaneF added(plane.width(), plane.height());
  auto tables = file.Tables(kind);
  for (TomlTable& t : tables) DrawLine(added, pixel_size_mm, ReadLine(t, name, kind, amount_key));
  for (std::size_t i = 0; i < plane.size(); ++i) plane.values()[i] += added.values()[i];
  return !tables.empty();
}

// Reads every table of features, whether or not a pattern hides them, so that their keys are checked.
ParameterMaps ReadMaps(TomlTable& file, const Scene& scene, double pixel_size_mm) {
  const std::string name = scene.file.string();
  ParameterMaps maps(kPatchSize_px, kPatchSize_px, AverageSkin());
  for (int k = 0; k < kParameterCount; ++k) {
    const auto i = static_cast<std::size_t>(k);
    DrawVariation(maps.planes[i], pixel_size_mm, ReadVariation(file, kParameters[i]), scene.seed, k);
  }
  int index = 0;
  for (TomlTable& t : file.Tables("freckle")) {
    DrawFreckles(maps, pixel_size_mm, ReadFreckles(t, name), scene.seed, index++);
  }
  AddLines(file, name, "vein", "C_hd", pixel_size_mm, maps[Parameter::kC_hd]);
  PlaneF junction(kPatchSize_px, kPatchSize_px, static_cast<float>(scene.tissue.junction_absorbance));
  if (AddLines(file, name, "tattoo", "absorbance", pixel_size_mm, junction)) {
    maps.junction_absorbance.push_back(std::move(junction));
  }
  ClampToBounds(maps);
  return maps;
}

// Every map the mean of its cell, in cells x cells squares.
void AverageCells(ParameterMaps& maps, int cells) {
  const int side = kPatchSize_px / cells;
  const auto average = [&](PlaneF& plane) {
    for (int y = 0; y < kPatchSize_px; y += side) {
      for (int x = 0; x < kPatchSize_px; x += side) {
        double sum = 0.0;
        for (int row = y; row < y + side; ++row)
          sum += std::accumulate(plane.Row(row) + x, plane.Row(row) + x + side, 0.0);
        for (int row = y; row < y + side; ++row)
          std::fill_n(plane.Row(row) + x, side, static_cast<float>(sum / (side * side)));
      }
    }
  };
  for (PlaneF& plane : maps.planes) average(plane);
  for (PlaneF& plane : maps.junction_absorbance) average(plane);
}

}  // namespace

Scene ReadScene(const std::filesystem::path& path, double window_mm) {
  TomlTable file = TomlTable::ReadFile(path);
  Scene scene;
  scene.file = path;
  scene.name = file.String("name", path.stem().string());
  scene.seed = static_cast<std::uint64_t>(file.Integer("seed", 1, 0, 2147483647));
  scene.profiles = file.String("profiles", scene.profiles);
  MakeProfileSource(scene.profiles);  // throws for a name that does not exist
  scene.tissue = ReadTissueTable(file);
  Validate(scene.tissue);
  scene.pattern = ReadPattern(file, path.string());
  scene.bench = ReadBenchTable(file);
  if (const std::string stack = file.String("reflectance", ""); !stack.empty())
    scene.reflectance = path.parent_path() / stack;
  const auto cells = static_cast<int>(file.Integer("cells", kPatchSize_px, 1, kPatchSize_px));
  if (kPatchSize_px % cells != 0)
    throw InputError(path.string() + ": cells is " + std::to_string(cells) + "; it must divide " +
                     std::to_string(kPatchSize_px) + ".");
  ParameterMaps maps = ReadMaps(file, scene, window_mm / kPatchSize_px);
  AverageCells(maps, cells);
  if (!scene.pattern) scene.maps = std::move(maps);
  file.Finish();
  return scene;
}

PlaneF RenderPattern(const TestPattern& pattern, double window_mm) {
  PlaneF plane(kPatchSize_px, kPatchSize_px);
  const double pixel_size_mm = window_mm / kPatchSize_px;
  for (int y = 0; y < kPatchSize_px; ++y) {
    for (int x = 0; x < kPatchSize_px; ++x) {
      double share = 0.0;
      if (pattern.kind == TestPattern::Kind::kGradient) {
        share = (x + 0.5) / kPatchSize_px;
      } else if (pattern.kind == TestPattern::Kind::kChecker) {
        const int column = static_cast<int>((x + 0.5) * pixel_size_mm / pattern.period_mm);
        const int row = static_cast<int>((y + 0.5) * pixel_size_mm / pattern.period_mm);
        share = (column + row) % 2;
      } else if (pattern.kind == TestPattern::Kind::kSteps) {
        const auto rows = static_cast<int>(pattern.values.size()) / pattern.columns;
        const int cell = y * rows / kPatchSize_px * pattern.columns + x * pattern.columns / kPatchSize_px;
        plane(x, y) = static_cast<float>(pattern.values[static_cast<std::size_t>(cell)]);
        continue;
      }
      plane(x, y) = static_cast<float>(pattern.low + share * (pattern.high - pattern.low));
    }
  }
  return plane;
}

}  // namespace dermap
