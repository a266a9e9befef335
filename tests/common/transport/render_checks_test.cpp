// SPDX-License-Identifier: Apache-2.0
// Bad input ends in one sentence, not in a render.
#include "common/transport/render_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/core/error.h"

namespace dermap {
namespace {

using testing::HasSubstr;

std::string Sentence(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

// Each message must name what was found and what was expected.
TEST(RenderChecks, NameWhatIsWrongWithAModel) {
  const Band band{550.0, 10.0};
  ImagingConditions conditions;
  conditions.pixel_size_mm = 0.03;
  const ForwardOptions options;
  EXPECT_NO_THROW(CheckModelInputs({&band, 1}, conditions, options));
  EXPECT_THAT(Sentence([&] { CheckModelInputs({}, conditions, options); }), HasSubstr("no band"));
  EXPECT_THAT(Sentence([&] { CheckModelInputs({&band, 1}, {}, options); }), HasSubstr("--pixel-size-mm"));
  const Band negative{550.0, -1.0};
  EXPECT_THAT(Sentence([&] {
                CheckModelInputs({&negative, 1}, conditions, options);
              }),
              HasSubstr("width of -1"));
  ForwardOptions bad = options;
  bad.margin_mm = -0.5;
  EXPECT_THAT(Sentence([&] { CheckModelInputs({&band, 1}, conditions, bad); }), HasSubstr("-0.5"));
  bad = options;
  bad.terms = -7;
  EXPECT_THAT(Sentence([&] { CheckModelInputs({&band, 1}, conditions, bad); }), HasSubstr("-7"));
  bad = options;
  bad.path_lengths = 17;
  EXPECT_THAT(Sentence([&] { CheckModelInputs({&band, 1}, conditions, bad); }), HasSubstr("17; it must be"));
  bad = options;
  bad.gaussian_step = 4;
  EXPECT_THAT(Sentence([&] { CheckModelInputs({&band, 1}, conditions, bad); }), HasSubstr("every 4th"));
}

// The same for the planes of a render.
TEST(RenderChecks, NameThePlaneThatDoesNotFit) {
  ParameterMaps maps(4, 3, AverageSkin());
  EXPECT_NO_THROW(CheckMaps(maps, 8));
  EXPECT_THAT(Sentence([] { CheckMaps(ParameterMaps(), 8); }), HasSubstr("no pixels"));
  maps.junction_absorbance.resize(2, PlaneF(4, 3));
  EXPECT_THAT(Sentence([&] { CheckMaps(maps, 8); }),
              HasSubstr("2 planes of junction_absorbance for 8 bands"));
  maps.junction_absorbance.resize(1);
  EXPECT_NO_THROW(CheckMaps(maps, 8));
  maps[Parameter::kC_he] = PlaneF(3, 4);
  EXPECT_THAT(Sentence([&] { CheckMaps(maps, 8); }),
              HasSubstr("map 'C_he' is 3 x 4 pixels but C_m is 4 x 3"));
  maps = ParameterMaps(4, 3, AverageSkin());
  maps[Parameter::kBeta_m](2, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(Sentence([&] { CheckMaps(maps, 8); }),
              HasSubstr("'beta_m' holds a value that is not a finite number at x = 2, y = 1"));
  maps = ParameterMaps(4, 3, AverageSkin());
  const PlaneF light(5, 5, 1.0f);
  EXPECT_THAT(Sentence([&] { CheckLight({&light, 1}, maps, 8); }), HasSubstr("map 'light' is 5 x 5"));
}

}  // namespace
}  // namespace dermap
