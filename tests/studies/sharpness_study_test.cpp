// SPDX-License-Identifier: Apache-2.0
// The forward model on skin that changes from place to place, held to Monte Carlo.
#include "studies/sharpness_study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

// Source: Monte Carlo. A step and an edge of 4 mean free paths; and gather coupling, [D08 4.1]'s, beyond what
// is asked at the step, or the study could not tell.
TEST(SharpnessStudy, ReciprocalCouplingHoldsWhereGatherDoesNot) {
  const SharpnessStudy study = RunSharpnessStudy({.quick = true}, {});
  for (const Verdict& verdict : study.verdicts) EXPECT_TRUE(verdict.holds()) << verdict.claim;
  EXPECT_GT(study.points[0].gather.net, 0.04);
  EXPECT_LT(study.points[0].reciprocal.net, 0.5 * study.points[0].gather.net);
  const TemporaryFolder folder;
  WriteSharpnessStudy(folder.path() / "study", study);
  const auto json = nlohmann::json::parse(ReadTextFile(folder.path() / "study" / "sharpness.json"));
  EXPECT_EQ(json["points"].size(), 2u);
}

StripMisfit MisfitOf(const Strip& strip, std::uint64_t photons, Coupling coupling) {
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  return Compare(RenderStrip(strip, chromophores, *MakeProfileSource("exact"), coupling),
                 JudgeStrip(strip, chromophores, photons, 11, 2));
}

// Source: Monte Carlo. Asked: rms within 2 % more than its noise.
TEST(JudgedStrip, FrecklesAgreeWithMonteCarlo) {
  Strip strip{.wavelength_nm = 480.0, .skin = {}};
  for (int i = 0; i < 96; ++i) {
    const auto spot = [x_mm = (i + 0.5) * strip.pixel_size_mm](double at, double width) {
      return std::exp(-0.5 * std::pow((x_mm - at) / width, 2));
    };
    strip.skin.push_back(AverageSkin());
    strip.skin.back()[0] = 0.05 + 0.15 * spot(0.6, 0.12) + 0.2 * spot(1.4, 0.25) + 0.25 * spot(2.3, 0.06);
  }
  const StripMisfit misfit = MisfitOf(strip, 1500000, Coupling::kReciprocal);
  EXPECT_LT(misfit.noise, 0.03);
  EXPECT_LT(misfit.rms, misfit.noise + 0.02);
}

// Source: Monte Carlo, likewise.
TEST(JudgedStrip, DarkLineInTheDermisAgreesWithMonteCarlo) {
  Strip strip{.wavelength_nm = 560.0, .skin = {}};
  for (int i = 0; i < 96; ++i) {
    strip.skin.push_back(AverageSkin());
    strip.skin.back()[4] = std::abs((i + 0.5) * strip.pixel_size_mm - 1.44) < 0.15 ? 0.1 : 0.01;
  }
  const StripMisfit misfit = MisfitOf(strip, 600000, Coupling::kReciprocal);
  EXPECT_LT(misfit.noise, 0.03);
  EXPECT_LT(misfit.rms, misfit.noise + 0.02);
}

}  // namespace
}  // namespace dermap
