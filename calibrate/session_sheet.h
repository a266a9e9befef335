// SPDX-License-Identifier: Apache-2.0
// A session as it is found on disk, in one picture: what is missing, cut short or not what was captured is
// seen at a glance.
#pragma once

#include "common/files/picture.h"
#include "common/files/session.h"

namespace dermap {

struct SessionSheet {
  Plane<Rgb8> picture;
  int bad = 0;  // tiles in red
};

// One tile for each frame: black ones, then Spectralon and skin in order of wavelength; a red one for each
// frame that is not there, cannot be read, or has another SHA-256 than when it was captured, and for each
// filter of the plan of which there is none.
SessionSheet DrawSessionSheet(const Session& session);

// Filters of which the session has Spectralon or skin frames missing altogether.
bool LacksFrames(const Session& session);

}  // namespace dermap
