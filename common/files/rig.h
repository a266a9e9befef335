// SPDX-License-Identifier: Apache-2.0
// rig.toml (what the station is made of) and plan.toml (what a session shall take), parsed once into structs.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "common/files/rig_optics.h"
#include "common/files/toml_table.h"

namespace dermap {

// The range of wavelengths that the published spectra, and so everything of ours, cover.
inline constexpr double kShortestWavelengthNm = 350.0;
inline constexpr double kLongestWavelengthNm = 1000.0;

struct WheelSlot {
  int slot = 0;                // counts from 1, as on the wheel's face
  double wavelength_nm = 0.0;  // 0 for the opaque slot
  double fwhm_nm = 10.0;       // 0 for the opaque slot
  bool opaque = false;
};

struct RigConfig {
  std::string name;
  std::string camera_driver = "simulated";
  std::string camera_port = "usb:";  // where the driver looks for it: "usb:", "ptpip:ADDRESS:PORT:PORT"
  std::string camera_model;          // libgphoto2's name; empty: the first one found
  std::string wheel_driver = "simulated";
  std::string wheel_serial;      // where several are attached; empty: any
  double flash_recycle_s = 0.0;  // from one flash to the next
  std::vector<WheelSlot> slots;  // ascending slot
  double window_mm = 7.5;        // side of the square cut into the tape
  double view_angle_deg = 30.0;  // between the camera's axis and the skin's normal
  double light_angle_deg = 0.0;  // between the flash's axis and the skin's normal
  // Relative to the config directory; absolute where the rig's own folder has it.
  std::filesystem::path spectralon_csv = "spectra/spectralon_99_labsphere.csv";
  double gray_card_reflectance = 0.30;
  std::array<double, 4> gray_card_region{0.80, 0.25, 0.14,
                                         0.5};  // x, y, width, height as shares of the frame
  RigOptics optics;
  std::filesystem::path simulated_scene;  // for the simulated drivers: a scene TOML; empty: none
};

struct PlannedExposure {
  int slot = 0;
  double exposure_ms = 10.0;  // [D08 6.2] 1/100 s
  int iso = 400;
};

struct PlanConfig {
  std::string subject;  // a code, never a name
  std::string site;
  std::string notes;
  int black_frames = 1;                    // for each distinct exposure and ISO
  int spectralon_frames = 1;               // for each filter
  int skin_frames = 1;                     // for each filter
  bool adapt_exposure = true;              // the ISO of a filter whose frames come out too bright or too dark
  std::vector<PlannedExposure> exposures;  // in the order of the plan
};

// Both throw InputError naming file, line and key. ReadRig looks for the files that a rig names beside the
// rig file first, then in the config directory.
RigConfig ReadRig(const std::filesystem::path& path);
PlanConfig ReadPlan(const std::filesystem::path& path);
// The same out of an open table, files left as they are named (session.json holds both).
RigConfig ReadRigTable(TomlTable& table);
PlanConfig ReadPlanTable(TomlTable& table);

// Whether this rig can take this plan: throws InputError naming the slot that it lacks, or the missing opaque
// slot.
void CheckPlan(const RigConfig& rig, const PlanConfig& plan);

// The slot of that number, or nullptr; the opaque slot, or nullptr.
const WheelSlot* FindSlot(const RigConfig& rig, int slot);
const WheelSlot* FindOpaqueSlot(const RigConfig& rig);

}  // namespace dermap
