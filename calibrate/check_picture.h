// SPDX-License-Identifier: Apache-2.0
// One picture that shows whether a calibration found what it should: for each band the captured frame with
// its window and a grid through the patch, and beside it what is left after alignment.
#pragma once

#include "calibrate/calibrate.h"
#include "common/files/picture.h"

namespace dermap {

Plane<Rgb8> CheckPicture(const CalibrationResult& result);
// What stands over a band's two panels: how well its window is known, and how far alignment has moved it.
std::string WindowCaption(const BandCalibration& band);
std::string ResidualCaption(const BandCalibration& band);

}  // namespace dermap
