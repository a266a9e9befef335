// SPDX-License-Identifier: Apache-2.0
// A calibrated session of the optical bench against the bench's own truth.
#pragma once

#include <vector>

#include "acquire/simulated/optical_bench.h"
#include "calibrate/calibrate.h"
#include "studies/calibration_rig.h"

namespace dermap {

Shot ShotOf(const FrameRecord& record);

// Of a patch's mean: its error, and how large the session itself says that it is, one standard deviation of
// the photosites' noise, of the gray card's and of the nonlinearity together.
struct PatchError {
  double error = 0.0, sigma = 0.0;  // reflectance
};

// Patch by patch, band by band; the patches are a pattern of steps, four in a row.
std::vector<PatchError> PatchErrors(const CalibrationResult& result, const std::vector<double>& patches);
// Errors of several sessions of the same patches.
void JudgePatches(const std::vector<std::vector<PatchError>>& sessions, const std::vector<double>& patches,
                  CalibrationStudyRig& rig);
void JudgeAlignment(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                    CalibrationStudyRig& rig);
// The bench's patch, where the skin of the bands' shots lay on average.
void JudgeSkin(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
               CalibrationStudyRig& rig);

}  // namespace dermap
