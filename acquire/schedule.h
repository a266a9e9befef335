// SPDX-License-Identifier: Apache-2.0
// Which frames a plan asks for, and in which order they are taken.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include "common/files/rig.h"
#include "common/files/session.h"

namespace dermap {

struct ExposureSetting {
  double exposure_ms = 0.0;
  int iso = 0;
  auto operator<=>(const ExposureSetting&) const = default;
};

// Black frames for each distinct exposure and ISO through the opaque slot, then Spectralon for each filter,
// then skin for each filter (all filters before any is repeated, so that the subject moves little between
// bands): that is how they are numbered. Files, hashes and times are still empty. Throws InputError where the
// rig cannot take the plan.
std::vector<FrameRecord> MakeSchedule(const RigConfig& rig, const PlanConfig& plan);

// Whose turn it is first: frames of a lower number. One black frame begins, since a lit one shows that the
// wheel has lost its slots; the others come between Spectralon and skin, where the wheel passes its opaque
// slot anyway. A person who turns the wheel by hand turns it once for all of them.
int TurnOf(const FrameRecord& frame, const std::vector<FrameRecord>& schedule, bool turned_by_hand);
std::vector<FrameRecord> InOrderOfTaking(std::vector<FrameRecord> schedule, bool turned_by_hand);

// SHA-256 of everything that must be the same for a session to be resumed: the schedule, the rig's geometry
// and the contents of the simulated scene.
std::string Fingerprint(const RigConfig& rig, const std::vector<FrameRecord>& schedule);

// Takes all frames of a filter that the change is for at its new ISO.
void ApplyExposureChange(const ExposureChange& change, std::vector<FrameRecord>& schedule);

// Exposure and ISO of frames that were taken and that the schedule has no black frame for, each once.
std::vector<ExposureSetting> SettingsWithoutBlack(const std::vector<FrameRecord>& taken,
                                                  const std::vector<FrameRecord>& schedule);
// Adds `count` black frames for one setting behind all others, so that the numbers of those there stay.
void AddBlackFrames(const ExposureSetting& setting, int count, const RigConfig& rig,
                    std::vector<FrameRecord>& schedule);

// Whether both stand for the same place in a schedule.
bool SamePlace(const FrameRecord& a, const FrameRecord& b);

}  // namespace dermap
