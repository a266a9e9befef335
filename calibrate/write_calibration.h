// SPDX-License-Identifier: Apache-2.0
// What a calibration leaves behind: the stack, STACK.calibration.json beside it and pictures in
// STACK.calibration/.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "calibrate/calibrate.h"

namespace dermap {

// DIR/stack.exr -> DIR/stack.calibration.json and DIR/stack.calibration/450nm_frame.png,
// 450nm_reflectance.png, ... Every file is written atomically, the stack last. Throws StorageError.
void WriteCalibration(const std::filesystem::path& stack_path, const CalibrationResult& result);

// The contents of STACK.calibration.json but for `pictures`; keys in calibrate/README.md.
nlohmann::json CalibrationRecord(const CalibrationResult& result);

std::filesystem::path CalibrationRecordPath(const std::filesystem::path& stack_path);

}  // namespace dermap
