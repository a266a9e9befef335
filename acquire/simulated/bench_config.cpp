// SPDX-License-Identifier: Apache-2.0
// Reading [bench], key by key.
#include "acquire/simulated/bench_config.h"

#include <cmath>
#include <string>

#include "common/core/error.h"

namespace dermap {
namespace {

std::array<double, 2> ReadPair(TomlTable& table, const std::string& key,
                               const std::array<double, 2>& fallback) {
  const std::vector<double> v = table.Numbers(key, {fallback[0], fallback[1]});
  if (v.size() != 2) {
    throw InputError("[bench] " + key + " has " + std::to_string(v.size()) +
                     " numbers where x and y are expected.");
  }
  return {v[0], v[1]};
}

void ReadView(TomlTable& t, BenchConfig& c) {
  c.width_px = t.Integer("width_px", c.width_px, 32, 8192);
  c.height_px = t.Integer("height_px", c.height_px, 32, 8192);
  if (c.width_px % 2 != 0 || c.height_px % 2 != 0) {
    throw InputError("[bench] width_px and height_px are " + std::to_string(c.width_px) + " and " +
                     std::to_string(c.height_px) + "; the RGGB mosaic needs even numbers.");
  }
  c.window_center_px = ReadPair(t, "window_center_px", c.window_center_px);
  c.scale_px_per_mm = t.Number("scale_px_per_mm", c.scale_px_per_mm, 1.0, 1000.0);
  c.camera_distance_mm = t.Number("camera_distance_mm", c.camera_distance_mm, 20.0, 10000.0);
  const std::string filters = t.String("filters", "rggb");
  if (filters != "rggb" && filters != "xtrans" && filters != "none")
    throw InputError("[bench] filters is \"" + filters + "\"; it must be \"rggb\", \"xtrans\" or \"none\".");
  c.filters = filters == "rggb"   ? BenchConfig::Filters::kRggb
              : filters == "none" ? BenchConfig::Filters::kNone
                                  : BenchConfig::Filters::kXTrans;
  c.psf_sigma_px = t.Number("psf_sigma_px", c.psf_sigma_px, 0.0, 20.0);
  c.distortion_k1 = t.Number("distortion_k1", c.distortion_k1, -0.3, 0.3);
}

void ReadLight(TomlTable& t, BenchConfig& c) {
  c.white_electrons = t.Number("white_electrons", c.white_electrons, 1.0, 1e7);
  c.vignetting = t.Number("vignetting", c.vignetting, 0.0, 0.9);
  c.flash_unevenness = t.Number("flash_unevenness", c.flash_unevenness, 0.0, 0.9);
  c.flash_drift = t.Number("flash_drift", c.flash_drift, 0.0, 0.3);
  for (const double shot : t.Numbers("misfired_shots", {})) {
    if (shot < 1.0 || shot != std::floor(shot)) {
      throw InputError("[bench] misfired_shots holds " + std::to_string(shot) +
                       "; shots are whole numbers from 1.");
    }
    c.misfired_shots.push_back(static_cast<int>(shot));
  }
  c.stray_light = t.Number("stray_light", c.stray_light, 0.0, 0.5);
  c.polarizer_sign = t.Integer("polarizer_sign", c.polarizer_sign, -1, 1);
  c.polarizer_spectralon = t.Number("polarizer_spectralon", c.polarizer_spectralon, 0.0, 0.9);
  c.polarizer_skin = t.Number("polarizer_skin", c.polarizer_skin, 0.0, 0.9);
  c.polarizer_leak = t.Number("polarizer_leak", c.polarizer_leak, 0.0, 0.2);
}

void ReadSubject(TomlTable& t, BenchConfig& c) {
  c.motion_shift_mm = t.Number("motion_shift_mm", c.motion_shift_mm, 0.0, 5.0);
  c.motion_rotation_deg = t.Number("motion_rotation_deg", c.motion_rotation_deg, 0.0, 10.0);
  c.stretch = t.Number("stretch", c.stretch, 0.0, 0.1);
  c.stretch_mm = t.Number("stretch_mm", c.stretch_mm, 0.0, 1.0);
  c.second_window_mm = t.Number("second_window_mm", c.second_window_mm, 0.0, 20.0);
  c.corner_radius_mm = t.Number("corner_radius_mm", c.corner_radius_mm, 0.0, 5.0);
  c.fray_mm = t.Number("fray_mm", c.fray_mm, 0.0, 2.0);
  c.hairs = t.Integer("hairs", c.hairs, 0, 1000);
  c.hair_mm = t.Number("hair_mm", c.hair_mm, 0.0, 1.0);
  c.shadow = t.Number("shadow", c.shadow, 0.0, 1.0);
  c.tape_reflectance = t.Number("tape_reflectance", c.tape_reflectance, 0.0, 1.0);
  c.tape_texture = t.Number("tape_texture", c.tape_texture, 0.0, 1.0);
}

void ReadSensor(TomlTable& t, BenchConfig& c) {
  c.shot_noise = t.Boolean("shot_noise", c.shot_noise);
  c.full_well_electrons = t.Number("full_well_electrons", c.full_well_electrons, 100.0, 1e7);
  c.read_noise_electrons = t.Number("read_noise_electrons", c.read_noise_electrons, 0.0, 1000.0);
  c.read_noise_dn = t.Number("read_noise_dn", c.read_noise_dn, 0.0, 100.0);
  c.black_level_dn = t.Integer("black_level_dn", c.black_level_dn, 0, 1024);
  c.black_pattern_dn = t.Number("black_pattern_dn", c.black_pattern_dn, 0.0, 100.0);
  c.response_pattern = t.Number("response_pattern", c.response_pattern, 0.0, 0.2);
  c.dark_current_electrons_per_s =
      t.Number("dark_current_electrons_per_s", c.dark_current_electrons_per_s, 0.0, 1e6);
  c.hot_photosites = t.Integer("hot_photosites", c.hot_photosites, 0, 100000);
  c.dead_photosites = t.Integer("dead_photosites", c.dead_photosites, 0, 100000);
  c.nonlinearity = t.Number("nonlinearity", c.nonlinearity, -0.2, 0.2);
}

}  // namespace

BenchConfig BenchConfig::Ideal() {
  BenchConfig c;
  c.psf_sigma_px = c.vignetting = c.flash_unevenness = c.flash_drift = 0.0;
  c.motion_shift_mm = c.motion_rotation_deg = c.tape_texture = 0.0;
  c.shot_noise = false;
  c.read_noise_electrons = c.read_noise_dn = c.black_pattern_dn = c.response_pattern = 0.0;
  c.dark_current_electrons_per_s = 0.0;
  c.hot_photosites = c.dead_photosites = 0;
  return c;
}

BenchConfig ReadBenchTable(TomlTable& file) {
  auto table = file.Table("bench");
  if (!table) return {};
  const std::string effects = table->String("effects", "all");
  if (effects != "all" && effects != "ideal") {
    throw InputError("[bench] effects is \"" + effects + "\"; it must be \"all\" or \"ideal\".");
  }
  BenchConfig config = effects == "ideal" ? BenchConfig::Ideal() : BenchConfig{};
  ReadView(*table, config);
  ReadLight(*table, config);
  ReadSubject(*table, config);
  ReadSensor(*table, config);
  table->Finish();
  return config;
}

}  // namespace dermap
