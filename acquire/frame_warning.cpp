// SPDX-License-Identifier: Apache-2.0
// Tolerances, and the words.
#include "acquire/frame_warning.h"

#include <cmath>

#include "acquire/exposure_advice.h"
#include "acquire/session_folder.h"

namespace dermap {
namespace {

constexpr double kDriftToWarn = 0.1;
constexpr double kIsoTolerance = 0.02, kExposureTolerance = 0.2;  // of what a file says about itself

std::string RemedyFor(const FrameRecord& f, const ExposureAdvice& advice) {
  if (!advice.isos.empty()) {
    return "take slot " + std::to_string(f.slot) + " at ISO " + std::to_string(advice.isos.front()) +
           " in the plan";
  }
  return advice.problem == ExposureProblem::kSaturated ? "lower the flash's power or close the aperture"
                                                       : "raise the flash's power or open the aperture";
}

std::string SizeText(const FrameSize& size) {
  return std::to_string(size.width_px) + " x " + std::to_string(size.height_px);
}

}  // namespace

std::string WrongSettings(const FrameRecord& planned, const FrameCheck& check, const FrameSize& size) {
  if (size != FrameSize{} && check.size != size)
    return "is " + SizeText(check.size) + " in place of " + SizeText(size) +
           " photosites, as the first frame is";
  if (check.iso > 0.0 && std::abs(check.iso / planned.iso - 1.0) > kIsoTolerance) {
    return "was taken at ISO " + std::to_string(std::lround(check.iso)) + " in place of " +
           std::to_string(planned.iso);
  }
  if (check.exposure_ms > 0.0 &&
      std::abs(check.exposure_ms / planned.exposure_ms - 1.0) > kExposureTolerance) {
    return "was exposed for " + std::to_string(check.exposure_ms) + " ms in place of " +
           std::to_string(planned.exposure_ms);
  }
  return "";
}

std::string WarningAbout(const FrameRecord& f, const FrameCheck& check, const LightJudgement& light,
                         double gray_card_reflectance) {
  if (light.problem != LightProblem::kNone) return DescribeFrame(f) + " " + DescribeLight(light);
  const ExposureAdvice advice = AdviseExposure(f, check, gray_card_reflectance);
  if (advice.problem != ExposureProblem::kNone)
    return DescribeFrame(f) + ": " + advice.why + "; remedy: " + RemedyFor(f, advice);
  if (std::abs(light.drift) > kDriftToWarn) {
    return DescribeFrame(f) + ": the gray card is " + PercentText(std::abs(light.drift)) +
           (light.drift > 0 ? " brighter" : " darker") + " than in this filter's first frame";
  }
  return "";
}

}  // namespace dermap
