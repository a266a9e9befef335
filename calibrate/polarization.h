// SPDX-License-Identifier: Apache-2.0
// How much the signals of Spectralon and of skin vary with the position of the camera's polarizer [D08 6.4],
// from a session with frames in both positions.
#pragma once

#include <string>
#include <vector>

#include "calibrate/frames.h"
#include "common/files/rig_optics.h"

namespace dermap {

struct PolarizationBand {
  double wavelength_nm = 0.0;
  Known spectralon;  // (S_s - S_p) / (S_s + S_p)
  Known skin;
};

struct PolarizationMeasurement {
  std::vector<PolarizationBand> bands;  // ascending wavelength
  Known gray_card;                      // the card's own amplitude, from the flashes of all frames
  double flash_scatter = 0.0;           // relative standard deviation of the flash from shot to shot
};

// Every wavelength needs Spectralon and skin frames in both positions, and the session black frames. The gray
// card takes out what the flash did from shot to shot; since the card varies with the polarizer too, its own
// amplitude, the mean over all frames, is put back. Throws InputError.
PolarizationMeasurement MeasurePolarization(const Session& session, const FrameReader& read);

// A [polarization] table for rig.toml, with which position `sign = -1` means.
std::string PolarizationToml(const PolarizationMeasurement& measurement);

}  // namespace dermap
