// SPDX-License-Identifier: Apache-2.0
// Plan and rig to a list of frames.
#include "acquire/schedule.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

std::vector<ExposureSetting> DistinctSettings(const PlanConfig& plan) {
  std::vector<ExposureSetting> settings;
  for (const PlannedExposure& e : plan.exposures) settings.push_back({e.exposure_ms, e.iso});
  std::sort(settings.begin(), settings.end());
  settings.erase(std::unique(settings.begin(), settings.end()), settings.end());
  return settings;
}

FrameRecord Frame(FrameRole role, const WheelSlot& slot, double exposure_ms, int iso) {
  FrameRecord f;
  f.role = role;
  f.slot = slot.slot;
  f.wavelength_nm = role == FrameRole::kBlack ? 0.0 : slot.wavelength_nm;
  f.fwhm_nm = role == FrameRole::kBlack ? 0.0 : slot.fwhm_nm;
  f.exposure_ms = exposure_ms;
  f.iso = iso;
  return f;
}

void AddFilters(std::vector<FrameRecord>& schedule, const RigConfig& rig, const PlanConfig& plan,
                FrameRole role, int repeats) {
  for (int r = 0; r < repeats; ++r) {
    for (const PlannedExposure& e : plan.exposures) {
      schedule.push_back(Frame(role, *FindSlot(rig, e.slot), e.exposure_ms, e.iso));
    }
  }
}

}  // namespace

std::vector<FrameRecord> MakeSchedule(const RigConfig& rig, const PlanConfig& plan) {
  CheckPlan(rig, plan);
  std::vector<FrameRecord> schedule;
  if (plan.black_frames > 0) {
    const WheelSlot* opaque = FindOpaqueSlot(rig);
    if (opaque == nullptr) {
      throw InputError("the plan asks for black frames, but rig '" + rig.name +
                       "' has no opaque slot; remedy: mark one with opaque = true, or set black_frames = 0");
    }
    for (const auto& [exposure_ms, iso] : DistinctSettings(plan)) {
      for (int r = 0; r < plan.black_frames; ++r)
        schedule.push_back(Frame(FrameRole::kBlack, *opaque, exposure_ms, iso));
    }
  }
  AddFilters(schedule, rig, plan, FrameRole::kSpectralon, plan.spectralon_frames);
  AddFilters(schedule, rig, plan, FrameRole::kSkin, plan.skin_frames);
  for (std::size_t i = 0; i < schedule.size(); ++i) schedule[i].number = static_cast<int>(i) + 1;
  return schedule;
}

int TurnOf(const FrameRecord& frame, const std::vector<FrameRecord>& schedule, bool turned_by_hand) {
  if (frame.role == FrameRole::kSpectralon) return 1;
  if (frame.role == FrameRole::kSkin) return 3;
  const auto first = std::find_if(schedule.begin(), schedule.end(),
                                  [](const FrameRecord& f) { return f.role == FrameRole::kBlack; });
  return turned_by_hand || first == schedule.end() || first->number == frame.number ? 0 : 2;
}

std::vector<FrameRecord> InOrderOfTaking(std::vector<FrameRecord> schedule, bool turned_by_hand) {
  const std::vector<FrameRecord> numbered = schedule;
  const auto turn = [&](const FrameRecord& f) { return TurnOf(f, numbered, turned_by_hand); };
  std::stable_sort(schedule.begin(), schedule.end(),
                   [&](const FrameRecord& a, const FrameRecord& b) { return turn(a) < turn(b); });
  return schedule;
}

std::string Fingerprint(const RigConfig& rig, const std::vector<FrameRecord>& schedule) {
  nlohmann::json j{{"camera", rig.camera_driver},
                   {"wheel", rig.wheel_driver},
                   {"window_mm", rig.window_mm},
                   {"view_angle_deg", rig.view_angle_deg},
                   {"gray_card_region", rig.gray_card_region}};
  if (rig.light_angle_deg != 0.0) j["light_angle_deg"] = rig.light_angle_deg;
  for (const FrameRecord& f : schedule) {
    j["frames"].push_back(
        {f.number, RoleName(f.role), f.slot, f.wavelength_nm, f.fwhm_nm, f.exposure_ms, f.iso});
  }
  if (!rig.simulated_scene.empty()) j["scene"] = Sha256OfFile(rig.simulated_scene);
  const std::string text = j.dump();
  return Sha256(std::as_bytes(std::span(text)));
}

void ApplyExposureChange(const ExposureChange& change, std::vector<FrameRecord>& schedule) {
  for (FrameRecord& f : schedule) {
    const bool meant = f.role == FrameRole::kSkin || f.role == change.role;
    if (f.slot == change.slot && f.role != FrameRole::kBlack && meant) f.iso = change.to_iso;
  }
}

std::vector<ExposureSetting> SettingsWithoutBlack(const std::vector<FrameRecord>& taken,
                                                  const std::vector<FrameRecord>& schedule) {
  std::vector<ExposureSetting> lacking;
  for (const FrameRecord& f : taken) {
    const ExposureSetting setting{f.exposure_ms, f.iso};
    const bool black = std::any_of(schedule.begin(), schedule.end(), [&](const FrameRecord& b) {
      return b.role == FrameRole::kBlack && b.exposure_ms == f.exposure_ms && b.iso == f.iso;
    });
    if (!black && std::find(lacking.begin(), lacking.end(), setting) == lacking.end())
      lacking.push_back(setting);
  }
  return lacking;
}

void AddBlackFrames(const ExposureSetting& setting, int count, const RigConfig& rig,
                    std::vector<FrameRecord>& schedule) {
  for (int r = 0; r < count; ++r) {
    schedule.push_back(Frame(FrameRole::kBlack, *FindOpaqueSlot(rig), setting.exposure_ms, setting.iso));
    schedule.back().number = static_cast<int>(schedule.size());
  }
}

bool SamePlace(const FrameRecord& a, const FrameRecord& b) {
  return a.number == b.number && a.role == b.role && a.slot == b.slot && a.wavelength_nm == b.wavelength_nm &&
         a.fwhm_nm == b.fwhm_nm && a.exposure_ms == b.exposure_ms && a.iso == b.iso;
}

}  // namespace dermap
