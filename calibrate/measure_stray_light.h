// SPDX-License-Identifier: Apache-2.0
// The share of its light that a rig's lens spreads over the frame, from bright and dark targets behind the
// window in the tape; and what leaks through the crossed polarizers from a dark target's surface.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibrate/frames.h"
#include "common/files/rig_optics.h"

namespace dermap {

struct StrayLightBand {
  double wavelength_nm = 0.0;
  Known share;                            // by this band alone
  double tape = 0.0;                      // reflectance of the tape
  double darkest = 0.0, brightest = 0.0;  // means of frames, as shares of white's
  std::optional<Known> leak;
};

struct StrayLightMeasurement {
  Known share;
  std::optional<Known> leak;          // as a share of a perfect white diffuser's mean signal
  std::vector<StrayLightBand> bands;  // ascending wavelength
};

// Skin frames of the session show targets of at least two brightnesses behind one window that stands still.
// Through the lens, tape seems brighter by the share of what the frame is brighter, so neither the tape's
// reflectance nor its texture matter; where all targets are alike, the rig must state the former. Bands are
// combined by inverse variance. `dark_target`: what the darkest target reflects from below its surface; tells
// the leak. Throws InputError (CaptureFailure where there is something to be seen).
StrayLightMeasurement MeasureStrayLight(const Session& session, const FrameReader& read,
                                        const std::optional<Known>& dark_target);

// Keys for rig.toml.
std::string StrayLightToml(const StrayLightMeasurement& measurement);

}  // namespace dermap
