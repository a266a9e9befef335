// SPDX-License-Identifier: Apache-2.0
// Edits are read exactly or refused with a sentence.
#include "render/edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

// The five operators of edit.h.
TEST(Edit, ReadsEveryOperator) {
  const std::pair<const char*, EditOperation> cases[] = {{"C_hd=0.4", EditOperation::kSet},
                                                         {"C_hd*=0.4", EditOperation::kMultiply},
                                                         {"C_hd/=0.4", EditOperation::kDivide},
                                                         {"C_hd+=0.4", EditOperation::kAdd},
                                                         {"  C_hd  -= \t0.4 ", EditOperation::kSubtract}};
  for (const auto& [text, operation] : cases) {
    const MapEdit edit = ParseEdit(text);
    EXPECT_EQ(edit.parameter, Parameter::kC_hd) << text;
    EXPECT_EQ(edit.operation, operation) << text;
    EXPECT_EQ(edit.value, 0.4) << text;
  }
}

// All names of table 1 and the junction; numbers as C writes them.
TEST(Edit, ReadsEveryNameAndNumber) {
  for (int i = 0; i < kParameterCount; ++i) {
    const auto& info = kParameters[static_cast<std::size_t>(i)];
    EXPECT_EQ(ParseEdit(std::string(info.name) + "=1").parameter, static_cast<Parameter>(i));
  }
  EXPECT_EQ(ParseEdit("junction_absorbance=0.5").parameter, std::nullopt);
  EXPECT_EQ(ParseEdit("C_m=-1e-3").value, -1e-3);
  EXPECT_EQ(ParseEdit("C_m=+.5").value, 0.5);
  EXPECT_EQ(ParseEdit("C_m-=-2").value, -2.0);
}

// Whatever is not an edit is refused, and the sentence names the known parameters.
TEST(Edit, RefusesRubbish) {
  for (const char* text : {"",
                           " ",
                           "=",
                           "C_hd",
                           "C_hd*",
                           "C_hd*=",
                           "*=0.4",
                           "C_hd*=0.4x",
                           "C_hd*=0,4",
                           "C_hd*=x",
                           "C_xx*=0.4",
                           "c_hd*=0.4",
                           "C_hd**=0.4",
                           "C_hd==0.4",
                           "C_hd=+-1",
                           "C_hd=++1",
                           "C_hd=nan",
                           "C_hd=inf",
                           "C_hd=1e999",
                           "C_hd/=0",
                           "C_hd=1=2",
                           "C_hd*=0.4;C_m=0",
                           "C_hd *= 0.4 0.5",
                           "C_hd%=3"}) {
    const std::string sentence = SentenceOf<InputError>([&] { ParseEdit(text); });
    EXPECT_THAT(sentence, HasSubstr("C_m, beta_m, C_he, C_bc, C_hd, junction_absorbance")) << text;
    EXPECT_THAT(sentence, HasSubstr(std::string("'") + text + "'"));
  }
}

// Arithmetic by hand within the bounds of [D08 table 1]: C_hd 0 to 0.1.
TEST(Edit, AppliesAndClamps) {
  const ParameterVector average = AverageSkin();  // C_hd = 0.03
  const std::pair<const char*, float> cases[] = {
      {"C_hd=0.05", 0.05f},  {"C_hd*=0.5", 0.015f}, {"C_hd/=2", 0.015f}, {"C_hd+=0.02", 0.05f},
      {"C_hd-=0.01", 0.02f}, {"C_hd*=10", 0.1f},    {"C_hd-=1", 0.0f}};
  for (const auto& [text, expected] : cases) {
    ParameterMaps maps(3, 2, average);
    ApplyEdit(maps, ParseEdit(text), 0.0175);
    for (const float value : maps[Parameter::kC_hd].values()) EXPECT_NEAR(value, expected, 1e-7) << text;
    for (const float value : maps[Parameter::kC_m].values()) EXPECT_FLOAT_EQ(value, 0.06f);
  }
}

// The note counts what was clamped; values that sit on a bound are not clamped by an edit that leaves them
// there.
TEST(Edit, SaysHowManyPixelsWereClamped) {
  ParameterMaps maps(4, 1, AverageSkin());
  maps[Parameter::kC_hd](0, 0) = 0.09f;
  EXPECT_THAT(ApplyEdit(maps, ParseEdit("C_hd*=2"), 0.0),
              HasSubstr("1 of 4 values were clamped to the bounds 0 to 0.1"));
  EXPECT_EQ(ApplyEdit(maps, ParseEdit("C_hd*=1"), 0.0), "Edited: C_hd*=1.");
}

// [D08 5.3]: every patch has the base absorbance, so an edit must start from it where the maps have none.
TEST(Edit, JunctionStartsFromTheBaseValue) {
  ParameterMaps maps(2, 2, AverageSkin());
  ApplyEdit(maps, ParseEdit("junction_absorbance+=0.5"), 0.0175);
  ASSERT_EQ(maps.junction_absorbance.size(), 1u);
  EXPECT_NEAR(maps.junction_absorbance[0](1, 1), 0.5175, 1e-6);
  maps.junction_absorbance.emplace_back(2, 2, 1.0f);
  ApplyEdit(maps, ParseEdit("junction_absorbance*=2"), 0.0175);
  EXPECT_NEAR(maps.junction_absorbance[0](0, 0), 1.035, 1e-6);
  EXPECT_NEAR(maps.junction_absorbance[1](0, 0), 2.0, 1e-6);
}

}  // namespace
}  // namespace dermap
