// SPDX-License-Identifier: Apache-2.0
#include "common/files/tissue_config.h"

#include <gmock/gmock.h>

#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// DESIGN section 5: the keys of [tissue]; what is absent keeps the published value (0.25 mm, 1.4, 1.38, P
// 0.0175).
TEST(TissueConfig, ReadsEveryKeyAndKeepsDefaults) {
  const TemporaryFolder folder;
  const TissueConfig all =
      ReadTissueConfig(folder.Write("t.toml",
                                    "[tissue]\nepidermis_thickness_mm = 0.1\nn_epidermis = 1.45\nn_dermis = "
                                    "1.41\nn_outside = 1.1\nanisotropy = 0.5\n"
                                    "oxygenation_epidermis = 0.5\noxygenation_dermis = "
                                    "0.9\njunction_absorbance = 0.3\nscattering_amplitude = 2\n"
                                    "scattering_slope = -0.5\n"));
  EXPECT_EQ(all.epidermis_thickness_mm, 0.1);
  EXPECT_EQ(all.n_epidermis, 1.45);
  EXPECT_EQ(all.n_dermis, 1.41);
  EXPECT_EQ(all.n_outside, 1.1);
  EXPECT_EQ(all.anisotropy, 0.5);
  EXPECT_EQ(all.oxygenation_epidermis, 0.5);
  EXPECT_EQ(all.oxygenation_dermis, 0.9);
  EXPECT_EQ(all.junction_absorbance, 0.3);
  EXPECT_EQ(all.scattering_amplitude, 2.0);
  EXPECT_EQ(all.scattering_slope, -0.5);
  const TissueConfig none = ReadTissueConfig(folder.Write("e.toml", ""));
  EXPECT_EQ(none.epidermis_thickness_mm, 0.25);
  EXPECT_EQ(none.n_epidermis, 1.4);
  EXPECT_EQ(none.n_dermis, 1.38);
  EXPECT_EQ(none.junction_absorbance, 0.0175);
}

// A range belongs to TissueConfig; the file and the key belong to the sentence.
TEST(TissueConfig, NamesFileAndKeyOfWhatCannotBe) {
  const TemporaryFolder folder;
  const auto sentence = [&](const std::string& text) {
    const auto path = folder.Write("t.toml", text);
    return SentenceOf<InputError>([&] { ReadTissueConfig(path); });
  };
  EXPECT_THAT(sentence("[tissue]\noxygenation_dermis = 1.5\n"),
              AllOf(HasSubstr("t.toml line 1"), HasSubstr("oxygenation_dermis"), HasSubstr("1.5")));
  EXPECT_THAT(sentence("[tissue]\nthickness_mm = 0.2\n"), HasSubstr("unknown key 'tissue.thickness_mm'"));
  EXPECT_THAT(sentence("[tisue]\n"), HasSubstr("did you mean 'tissue'?"));
  EXPECT_THAT(sentence("[tissue]\nn_dermis = nan\n"), HasSubstr("n_dermis"));
}

}  // namespace
}  // namespace dermap
