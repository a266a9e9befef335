// SPDX-License-Identifier: Apache-2.0
// What must be right before the first frame: clock, slots, room on disk and card, settings of the camera.
#pragma once

#include "acquire/devices/station.h"
#include "acquire/session_folder.h"

namespace dermap {

// Throws InputError, StorageError or DeviceError with what is not.
void CheckBeforeFirstFrame(const SessionFolder& folder, Station& station);

}  // namespace dermap
