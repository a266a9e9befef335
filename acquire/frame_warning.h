// SPDX-License-Identifier: Apache-2.0
// What a frame's own file says against it: sentences for the log and the operator.
#pragma once

#include <string>

#include "acquire/frame_check.h"
#include "acquire/light_memory.h"

namespace dermap {

// Where the file says that it was taken at other settings, or has not `size` (0 x 0: any will do); empty
// where all is right. Cameras that say nothing are believed.
std::string WrongSettings(const FrameRecord& planned, const FrameCheck& check, const FrameSize& size);

// About a frame that is kept all the same; empty where it is fine.
std::string WarningAbout(const FrameRecord& frame, const FrameCheck& check, const LightJudgement& light,
                         double gray_card_reflectance);

}  // namespace dermap
