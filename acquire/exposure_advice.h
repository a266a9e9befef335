// SPDX-License-Identifier: Apache-2.0
// What the brightness of a good frame says about its filter's ISO: kept, too high, too low, and which would
// suit.
#pragma once

#include <string>
#include <vector>

#include "acquire/frame_check.h"
#include "common/files/session.h"

namespace dermap {

enum class ExposureProblem { kNone, kSaturated, kUnderexposed };

struct ExposureAdvice {
  ExposureProblem problem = ExposureProblem::kNone;
  std::string why;        // "3.2 % of the photosites are saturated"; empty where there is no problem
  std::vector<int> isos;  // that suit better, the best first; empty where none does
};

// `frame` says with which ISO it was taken, `gray_card_reflectance` how bright the card in view is. Black
// frames are never judged.
ExposureAdvice AdviseExposure(const FrameRecord& frame, const FrameCheck& check,
                              double gray_card_reflectance);

// "30.5 %"
std::string PercentText(double share);

}  // namespace dermap
