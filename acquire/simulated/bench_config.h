// SPDX-License-Identifier: Apache-2.0
// The [bench] table of a scene file: every effect of the simulated optical bench, each of which can be
// switched off. Pixel coordinates have the centre of the first photosite at (0, 0), as OpenCV has.
#pragma once

#include <array>
#include <vector>

#include "common/files/toml_table.h"

namespace dermap {

struct BenchConfig {
  // View.
  int width_px = 480;  // photosites
  int height_px = 360;
  std::array<double, 2> window_center_px{190.0, 179.5};
  double scale_px_per_mm = 40.0;  // at the window's centre, across the tilt
  double camera_distance_mm = 400.0;
  enum class Filters { kRggb, kXTrans, kNone };  // over the photosites; kNone: all see as green ones do
  Filters filters = Filters::kRggb;
  double psf_sigma_px = 0.5;   // lens and low-pass filter, Gaussian
  double distortion_k1 = 0.0;  // a point at the radius r of the half diagonal appears at r (1 + k1 r^2)

  // Light. The flash's energy does not depend on the shutter: a plan sets the level by ISO alone.
  double white_electrons =
      45000.0;  // a perfect white diffuser gives through an ideal 10 nm filter, at the response's peak
  double vignetting = 0.2;          // light lost in the frame's corner
  double flash_unevenness = 0.1;    // light lost 5 mm off the flash's axis
  double flash_drift = 0.02;        // standard deviation from shot to shot
  std::vector<int> misfired_shots;  // the flash stays dark
  double stray_light = 0.0;         // share of a frame's light that the lens spreads evenly over it
  int polarizer_sign = 0;           // -1: the camera's polarizer stands where signals are weaker; 0: no bias
  double polarizer_spectralon = 0.0527;  // amplitudes about the mean [D08 6.4]
  double polarizer_skin = 0.1996;
  double polarizer_leak = 0.0;  // reflectance that the surface adds through crossed polarizers

  // Subject.
  double motion_shift_mm = 0.3;  // largest, between shots
  double motion_rotation_deg = 1.0;
  double stretch = 0.0;     // largest strain of skin and tape, drawn a shot and axis
  double stretch_mm = 0.0;  // largest shift of the window's middle against its border
  double tape_reflectance = 0.03;
  double tape_texture = 0.15;     // relative standard deviation
  double second_window_mm = 0.0;  // side of another square cut, 1 mm to the right of the window; 0: none
  double corner_radius_mm = 0.0;  // of the window's cut
  double fray_mm = 0.0;           // how far fibres of the tape reach into the window
  int hairs = 0;                  // dark lines across the window and the tape
  double hair_mm = 0.08;          // their width
  double shadow = 0.0;            // light lost on one side of a diagonal through the window, in skin frames

  // Sensor.
  bool shot_noise = true;
  double full_well_electrons = 51000.0;  // reaches the white level at ISO 100
  double read_noise_electrons = 7.5;     // before the amplifier
  double read_noise_dn = 0.8;            // after it
  int black_level_dn = 126;
  double black_pattern_dn = 1.0;    // fixed offset of a photosite, standard deviation
  double response_pattern = 0.005;  // fixed response of a photosite, relative standard deviation
  double dark_current_electrons_per_s = 3.0;
  int hot_photosites = 12;
  int dead_photosites = 4;
  double nonlinearity = 0.0;  // light = signal (1 + nonlinearity signal / full scale)

  // Nothing but the view, the mosaic, the black level, the analogue-digital conversion and saturation.
  static BenchConfig Ideal();
};

// Reads [bench] out of an open scene file. `effects = "all"` (default) or "ideal" sets what keys do not say.
BenchConfig ReadBenchTable(TomlTable& file);

}  // namespace dermap
