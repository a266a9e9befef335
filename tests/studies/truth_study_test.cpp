// SPDX-License-Identifier: Apache-2.0
// The bound of a whole patch against what its definition says, and the study of the fit against the truth.
#include "studies/truth_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "fit/scene_choice.h"
#include "studies/coupled_bound.h"
#include "studies/noise_bound.h"
#include "studies/study_scenes.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

// 1 % noise on a patch of 6 x 6 pixels, which light crosses or not.
class CoupledBound : public ::testing::Test {
 protected:
  struct Bounds {
    std::vector<PlaneF> of_six, of_five;
    ParameterVector of_pixel;  // by itself, the one in the middle
  };
  Bounds At(double pixel_mm) const {
    const ForwardModel model(
        chromophores_, *MakeProfileSource("exact"), TissueConfig{}, StudyBands(),
        ImagingConditions{.pixel_size_mm = pixel_mm, .illumination = Illumination::kUniform}, {});
    std::vector<PlaneF> noise = model.Render(skin_);
    for (PlaneF& plane : noise)
      for (float& value : plane.values()) value *= 0.01f;
    const CoupledInformation information(model, skin_, noise);
    std::vector<Parameter> five = AllUnknowns();
    five.pop_back();
    return {information.Bound(AllUnknowns()), information.Bound(five),
            PixelNoiseBound(model, skin_, noise, kMiddle)};
  }
  static constexpr std::size_t kMiddle = 14;
  Chromophores chromophores_{ConfigDirectory() / "spectra"};
  // Not even: of even skin a render takes the closed form, and so do its derivatives.
  static ParameterMaps UnevenSkin() {
    ParameterMaps skin(6, 6, AverageSkin());
    for (std::size_t i = 0; i < 36; ++i) {
      skin[Parameter::kC_m].data()[i] *= i % 5 == 0 ? 1.3f : 1.0f;
      skin[Parameter::kC_hd].data()[i] *= i % 7 == 0 ? 1.3f : 1.0f;
    }
    return skin;
  }
  const ParameterMaps skin_ = UnevenSkin();
};

// Where pixels are so large that no light goes from one to the next, each is bounded as by itself.
TEST_F(CoupledBound, OfPixelsFarApartIsThatOfEach) {
  const Bounds far = At(80.0);
  for (int k = 0; k < kParameterCount; ++k)
    EXPECT_NEAR(far.of_five[k].data()[kMiddle], far.of_pixel[k], 0.01 * far.of_pixel[k]) << k;
}

// Blur takes detail away, and so does one unknown more: neither can make anything better known.
TEST_F(CoupledBound, GrowsWithBlurAndWithUnknowns) {
  const Bounds near = At(0.06), far = At(80.0);
  for (int k = 0; k < kParameterCount; ++k) {
    EXPECT_GT(near.of_five[k].data()[kMiddle], far.of_five[k].data()[kMiddle]) << k;
    EXPECT_GE(near.of_six[k].data()[kMiddle], 0.999 * near.of_five[k].data()[kMiddle]) << k;
  }
  EXPECT_GT(near.of_five[0].data()[kMiddle], 1.5 * far.of_five[0].data()[kMiddle]);
}

// Source: the scenes themselves. Whether all error bars are right is asked of the full study; a quick one has
// too few pixels to tell.
TEST(TruthStudy, FitsComeWithinTheBoundAndTheChoicePays) {
  const TemporaryFolder folder;
  const TruthStudy study = RunTruthStudy(folder.path(), {.quick = true}, {});
  ASSERT_EQ(study.points.size(), 6u);
  for (const char* claim : {"Cramer-Rao", "all free"}) {
    const auto verdict = std::find_if(study.verdicts.begin(), study.verdicts.end(), [&](const Verdict& v) {
      return v.claim.find(claim) != std::string::npos;
    });
    ASSERT_NE(verdict, study.verdicts.end()) << claim;
    EXPECT_TRUE(verdict->holds()) << verdict->claim << ": " << verdict->worst;
  }
  WriteTruthStudy(folder.path(), study);
  const auto json = nlohmann::json::parse(ReadTextFile(folder.path() / "truth.json"));
  EXPECT_EQ(json["points"].size(), 6u);
  const TruthStudy again = RunTruthStudy(folder.path(), {.quick = true}, {});  // from the journal
  EXPECT_EQ(again.points[3].parameters[2].error, study.points[3].parameters[2].error);
  EXPECT_NE(study.points[3].chosen.find("junction"), std::string::npos) << "a tattoo";
  EXPECT_LT(ErrorRatio(study, study.points[3], "paper"), 0.5);  // the five know no ink
}

}  // namespace
}  // namespace dermap
