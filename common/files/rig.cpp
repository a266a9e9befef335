// SPDX-License-Identifier: Apache-2.0
// rig.toml and plan.toml: keys, units, ranges and what must agree.
#include "common/files/rig.h"

#include <algorithm>
#include <set>
#include <system_error>

#include "common/core/error.h"
#include "common/files/text.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

constexpr int kMostSlots = 64;

WheelSlot ReadSlot(TomlTable& table) {
  WheelSlot slot;
  slot.slot = table.RequiredInteger("slot", 1, kMostSlots);
  slot.opaque = table.Boolean("opaque", false);
  if (slot.opaque) {
    for (const char* key : {"wavelength_nm", "fwhm_nm"}) {
      if (table.Number(key, 0.0, 0.0, kLongestWavelengthNm) != 0.0) {
        throw InputError(table.Where(key) + ": slot " + std::to_string(slot.slot) + " is opaque and has '" +
                         key + "'; remedy: remove one of the two");
      }
    }
    slot.fwhm_nm = 0.0;
  } else {
    slot.wavelength_nm = table.RequiredNumber("wavelength_nm", kShortestWavelengthNm, kLongestWavelengthNm);
    slot.fwhm_nm = table.Number("fwhm_nm", slot.fwhm_nm, 0.0, 200.0);
  }
  table.Finish();
  return slot;
}

void ReadWheel(TomlTable& file, RigConfig& rig) {
  auto wheel = file.Table("wheel");
  if (!wheel)
    throw InputError(file.Where() +
                     ": the table [wheel] is missing; remedy: add it, with its [[wheel.slot]]s");
  rig.wheel_driver = wheel->String("driver", rig.wheel_driver);
  rig.wheel_serial = wheel->String("serial", rig.wheel_serial);
  std::set<int> taken;
  bool opaque = false;
  for (TomlTable& table : wheel->Tables("slot")) {
    const WheelSlot slot = ReadSlot(table);
    if (!taken.insert(slot.slot).second) {
      throw InputError(table.Where("slot") + ": slot " + std::to_string(slot.slot) +
                       " is given twice; expected each slot of the wheel once");
    }
    if (slot.opaque && opaque) {
      throw InputError(table.Where("opaque") + ": a second opaque slot; expected at most one");
    }
    opaque = opaque || slot.opaque;
    rig.slots.push_back(slot);
  }
  wheel->Finish();
  if (rig.slots.size() == (opaque ? 1u : 0u)) {
    throw InputError(file.Where("wheel") +
                     ": no filter in the wheel; remedy: add [[wheel.slot]] with slot and "
                     "wavelength_nm");
  }
  std::sort(rig.slots.begin(), rig.slots.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
}

void ReadReferences(TomlTable& references, RigConfig& rig) {
  rig.spectralon_csv = references.String("spectralon_csv", rig.spectralon_csv.string());
  rig.gray_card_reflectance =
      references.Number("gray_card_reflectance", rig.gray_card_reflectance, 0.01, 1.0);
  const auto& fallback = rig.gray_card_region;
  const auto region = references.Numbers("gray_card_region", {fallback.begin(), fallback.end()});
  const bool inside = region.size() == 4 && region[0] >= 0 && region[1] >= 0 && region[2] > 0 &&
                      region[3] > 0 && region[0] + region[2] <= 1 && region[1] + region[3] <= 1;
  if (!inside) {
    throw InputError(
        references.Where("gray_card_region") +
        ": 'gray_card_region' is not a rectangle in the frame; expected [x, y, width, height] as shares "
        "of the frame, each from 0 to 1");
  }
  std::copy(region.begin(), region.end(), rig.gray_card_region.begin());
  references.Finish();
}

void ReadCamera(TomlTable& file, RigConfig& rig) {
  auto camera = file.Table("camera");
  if (!camera) return;
  rig.camera_driver = camera->String("driver", rig.camera_driver);
  rig.camera_port = camera->String("port", rig.camera_port);
  rig.camera_model = camera->String("model", rig.camera_model);
  camera->Finish();
}

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

// The scene as a path that opens; both places are named where neither has it.
fs::path FindScene(const fs::path& scene, const fs::path& rig_folder, const std::string& where) {
  if (IsFile(rig_folder / scene)) return (rig_folder / scene).lexically_normal();
  const fs::path shared = ConfigDirectory() / scene;
  if (IsFile(shared)) return shared;
  throw InputError(where + ": the scene " + scene.string() + " is neither beside the rig file nor at " +
                   shared.string() + "; remedy: correct 'scene'");
}

PlannedExposure ReadExposure(TomlTable& table) {
  PlannedExposure exposure;
  exposure.slot = table.RequiredInteger("slot", 1, kMostSlots);
  exposure.exposure_ms = table.Number("exposure_ms", exposure.exposure_ms, 0.01, 600000.0);
  exposure.iso = table.Integer("iso", exposure.iso, 25, 409600);
  table.Finish();
  return exposure;
}

}  // namespace

RigConfig ReadRigTable(TomlTable& file) {
  RigConfig rig;
  rig.name = file.String("name", rig.name);
  ReadCamera(file, rig);
  ReadWheel(file, rig);
  if (auto flash = file.Table("flash")) {
    rig.flash_recycle_s = flash->Number("recycle_s", rig.flash_recycle_s, 0.0, 120.0);
    flash->Finish();
  }
  if (auto geometry = file.Table("geometry")) {
    rig.window_mm = geometry->Number("window_mm", rig.window_mm, 0.5, 100.0);
    rig.view_angle_deg = geometry->Number("view_angle_deg", rig.view_angle_deg, 0.0, 80.0);
    rig.light_angle_deg = geometry->Number("light_angle_deg", rig.light_angle_deg, 0.0, 80.0);
    geometry->Finish();
  }
  if (auto references = file.Table("references")) ReadReferences(*references, rig);
  rig.optics = ReadRigOptics(file);
  if (auto simulated = file.Table("simulated")) {
    rig.simulated_scene = simulated->String("scene", "");
    simulated->Finish();
  }
  file.Finish();
  return rig;
}

RigConfig ReadRig(const fs::path& path) {
  TomlTable file = TomlTable::ReadFile(path);
  RigConfig rig = ReadRigTable(file);
  if (rig.name.empty()) rig.name = path.stem().string();
  const fs::path folder = path.parent_path();
  if (IsFile(folder / rig.spectralon_csv)) rig.spectralon_csv = fs::absolute(folder / rig.spectralon_csv);
  for (fs::path* csv : {&rig.optics.camera_csv, &rig.optics.flash_csv}) {
    if (!csv->empty() && IsFile(folder / *csv)) *csv = fs::absolute(folder / *csv);
  }
  if (!rig.simulated_scene.empty()) {
    rig.simulated_scene = FindScene(rig.simulated_scene, folder, file.Where("simulated"));
  }
  return rig;
}

PlanConfig ReadPlanTable(TomlTable& file) {
  PlanConfig plan;
  plan.subject = file.String("subject", plan.subject);
  plan.site = file.String("site", plan.site);
  plan.notes = file.String("notes", plan.notes);
  plan.black_frames = file.Integer("black_frames", plan.black_frames, 0, 1000);
  plan.spectralon_frames = file.Integer("spectralon_frames", plan.spectralon_frames, 1, 1000);
  plan.skin_frames = file.Integer("skin_frames", plan.skin_frames, 1, 1000);
  plan.adapt_exposure = file.Boolean("adapt_exposure", plan.adapt_exposure);
  std::set<int> taken;
  for (TomlTable& table : file.Tables("exposure")) {
    plan.exposures.push_back(ReadExposure(table));
    if (!taken.insert(plan.exposures.back().slot).second) {
      throw InputError(table.Where("slot") + ": slot " + std::to_string(plan.exposures.back().slot) +
                       " is planned twice; expected each slot once (skin_frames repeats frames)");
    }
  }
  file.Finish();
  if (plan.exposures.empty()) {
    throw InputError(file.Where() +
                     ": nothing to take; remedy: add [[exposure]] with slot, exposure_ms and iso");
  }
  return plan;
}

PlanConfig ReadPlan(const fs::path& path) {
  TomlTable file = TomlTable::ReadFile(path);
  return ReadPlanTable(file);
}

const WheelSlot* FindSlot(const RigConfig& rig, int slot) {
  const auto found =
      std::find_if(rig.slots.begin(), rig.slots.end(), [&](const auto& s) { return s.slot == slot; });
  return found == rig.slots.end() ? nullptr : &*found;
}

const WheelSlot* FindOpaqueSlot(const RigConfig& rig) {
  const auto found = std::find_if(rig.slots.begin(), rig.slots.end(), [](const auto& s) { return s.opaque; });
  return found == rig.slots.end() ? nullptr : &*found;
}

void CheckPlan(const RigConfig& rig, const PlanConfig& plan) {
  for (const PlannedExposure& exposure : plan.exposures) {
    const WheelSlot* slot = FindSlot(rig, exposure.slot);
    if (slot && !slot->opaque) continue;
    std::vector<std::string> filters;
    for (const WheelSlot& known : rig.slots) {
      if (!known.opaque) filters.push_back(std::to_string(known.slot));
    }
    throw InputError("the plan takes slot " + std::to_string(exposure.slot) + ", which " +
                     (slot ? "is the opaque one" : "does not exist") + " on rig '" + rig.name +
                     "'; expected one of its filters: " + Join(filters, ", "));
  }
  if (plan.black_frames > 0 && !FindOpaqueSlot(rig)) {
    throw InputError("the plan takes black frames, and rig '" + rig.name +
                     "' has no opaque slot; remedy: mark one with opaque = true, or set black_frames = 0");
  }
}

}  // namespace dermap
