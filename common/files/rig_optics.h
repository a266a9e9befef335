// SPDX-License-Identifier: Apache-2.0
// What is known of a rig's optics beyond its geometry, each number with one standard deviation: the tables
// [calibration], [polarization] and [gel] of rig.toml. What a rig does not say is not corrected.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "common/files/toml_table.h"

namespace dermap {

struct Known {
  double value = 0.0;
  double sigma = 0.0;  // one standard deviation
};

// Between the two positions of the camera's polarizer the signals of Spectralon and of skin under gel vary by
// these shares about their means [D08 6.4].
struct PolarizationConfig {
  int sign =
      0;  // -1: the camera's polarizer stands where signals are weaker (crossed), 1: where they are stronger
  std::vector<double> wavelengths_nm;  // of the amplitudes below; empty: one value for all
  std::vector<double> spectralon{0.0527};
  std::vector<double> skin{0.1996};
  double spectralon_sigma = 0.005;
  double skin_sigma = 0.02;
  Known leak;  // reflectance that the skin's surface adds through the crossed polarizers
};

struct RigOptics {
  Known certificate{1.0, 0.005};          // factor on the panel's certificate; its uncertainty, relative
  std::optional<Known> tape_reflectance;  // tells the stray light
  std::optional<Known> stray_light;       // share of a frame's light that the lens spreads over it
  std::optional<Known> nonlinearity;      // light = signal (1 + nonlinearity signal / full scale)
  double window_sigma_mm = 0.05;          // how well the window's side is known
  double distortion_k1 = 0.0;  // radius r of the frame's half diagonal appears at r (1 + k1 r^2 + k2 r^4)
  double distortion_k2 = 0.0;
  std::filesystem::path camera_csv;  // columns red, green, blue: relative response
  std::filesystem::path flash_csv;   // column relative_power
  std::optional<PolarizationConfig> polarization;
  std::optional<Known> gel;  // refractive index of the film on the skin
};

// Reads the three tables out of an open rig file; throws InputError.
RigOptics ReadRigOptics(TomlTable& rig);
// Adds the tables that say more than the defaults.
void AddRigOptics(const RigOptics& optics, nlohmann::json& rig);

}  // namespace dermap
