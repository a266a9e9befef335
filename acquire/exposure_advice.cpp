// SPDX-License-Identifier: Apache-2.0
// The flash is shorter than the shutter, so ISO alone sets the level, in proportion. Below the sensor's
// native ISO 100 the well fills before the numbers reach white, which no saturated photosite would show: no
// such ISO is proposed.
#include "acquire/exposure_advice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace dermap {
namespace {

constexpr double kSaturatedShare = 0.001;  // of the photosites; fewer are hot ones and highlights
constexpr double kLowestSpectralon = 0.35, kLowestSkin = 0.10;  // levels: 99th percentile of the frame
constexpr double kAim = 0.75;                                   // level, with room for the flash's drift
constexpr double kBlindStep = 0.5;     // one stop down, where all that could tell the level is saturated
constexpr double kSmallestStep = 0.8;  // down; a saturated frame is not helped by less than a third of a stop
constexpr double kReadableCard = 0.95;
constexpr std::array kIsos{100,  125,  160,  200,  250,  320,  400,  500,  640, 800,
                           1000, 1250, 1600, 2000, 2500, 3200, 4000, 5000, 6400};

// By what the ISO is to be multiplied. The card is darker than the target, and so still in range where the
// target is not; it tells how far beyond white that is.
double FactorOfSaturated(FrameRole role, const FrameCheck& check, double card_reflectance) {
  const double card = *std::max_element(check.card.begin(), check.card.end());
  if (role != FrameRole::kSpectralon || card <= 0.0 || card >= kReadableCard) return kBlindStep;
  return std::min(kSmallestStep, kAim * card_reflectance / card);
}

}  // namespace

std::string PercentText(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100.0 * share);
  return text;
}

ExposureAdvice AdviseExposure(const FrameRecord& frame, const FrameCheck& check, double card_reflectance) {
  ExposureAdvice advice;
  if (frame.role == FrameRole::kBlack) return advice;
  double factor = 1.0;
  const double lowest = frame.role == FrameRole::kSpectralon ? kLowestSpectralon : kLowestSkin;
  if (check.saturated_share > kSaturatedShare) {
    advice.problem = ExposureProblem::kSaturated;
    advice.why = PercentText(check.saturated_share) + " of the photosites are saturated";
    factor = FactorOfSaturated(frame.role, check, card_reflectance);
  } else if (check.level < lowest) {
    advice.problem = ExposureProblem::kUnderexposed;
    advice.why = "its brightest parts reach only " + PercentText(check.level) + " of the range";
    factor = kAim / std::max(check.level, 1e-3);
  }
  if (advice.problem == ExposureProblem::kNone) return advice;
  for (auto iso = kIsos.rbegin(); iso != kIsos.rend(); ++iso) {
    const bool right_way = factor < 1.0 ? *iso < frame.iso : *iso > frame.iso;
    if (right_way && *iso <= std::max(frame.iso * factor, double(kIsos.front()))) advice.isos.push_back(*iso);
  }
  return advice;
}

}  // namespace dermap
