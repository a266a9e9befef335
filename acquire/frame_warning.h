// SPDX-License-Identifier: Apache-2.0
// What a frame's own file says against it: sentences for the log and the operator.
#pragma once

#include <string>

#include "acquire/frame_check.h"
#include "acquire/light_memory.h"

namespace dermap {

// Where the file says that it was taken at other settings; empty where they are right. Cameras that say
// nothing are believed.
std::string WrongSettings(const FrameRecord& planned, const FrameCheck& check);

// About a frame that is kept all the same; empty where it is fine.
std::string WarningAbout(const FrameRecord& frame, const FrameCheck& check, const LightJudgement& light,
                         double gray_card_reflectance);

}  // namespace dermap
