// SPDX-License-Identifier: Apache-2.0
// A calibrated session of the optical bench against the bench's own truth.
#pragma once

#include <vector>

#include "acquire/simulated/optical_bench.h"
#include "calibrate/calibrate.h"
#include "studies/calibration_rig.h"

namespace dermap {

Shot ShotOf(const FrameRecord& record);

// Reflectances of a pattern of steps, four in a row.
void JudgePatches(const CalibrationResult& result, const std::vector<double>& patches,
                  CalibrationStudyRig& rig);
void JudgeAlignment(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                    CalibrationStudyRig& rig);
// `truth`: a plane for each of `bands`, on the stack's grid.
void JudgeSkin(const std::vector<PlaneF>& truth, const std::vector<Band>& bands,
               const CalibrationResult& result, CalibrationStudyRig& rig);

}  // namespace dermap
