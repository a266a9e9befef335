// SPDX-License-Identifier: Apache-2.0
#include "common/files/exr_file.h"

#include <gmock/gmock.h>

#include <random>

#include "common/files/stack.h"
#include "tests/common/files/exr_builder.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

ReflectanceStack NoisyStack(int width, int height) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  ReflectanceStack stack;
  stack.bands = {{450.0, 10.0}, {500.0, 10.0}};
  for (int i = 0; i < 2; ++i) {
    PlaneF& plane = stack.reflectance.emplace_back(width, height);
    for (float& value : plane.values()) value = uniform(random);
  }
  stack.pixel_size_mm = 0.03;
  return stack;
}

class ExrFileTest : public testing::Test {
 protected:
  std::string SentenceFor(const std::string& bytes) {
    const auto path = folder_.Write("some.exr", bytes);
    return SentenceOf<InputError>([&] { ReadReflectanceStack(path); });
  }
  static ExrBuilder Plain() {
    return ExrBuilder(4, 3).Channel("T.450,000000nm", ExrType::kFloat, [](int, int) { return 0.5; });
  }
  TemporaryFolder folder_;
};

// Half a file is no file: every length of the header and of the first chunks, then one in 97 of the rest.
TEST_F(ExrFileTest, NamesATruncatedFileAtEveryLength) {
  WriteReflectanceStack(folder_ / "whole.exr", NoisyStack(33, 40));
  const std::string whole = Slurp(folder_ / "whole.exr");
  ASSERT_GT(whole.size(), 8000u);
  for (std::size_t length = 0; length < whole.size(); length += length < 900 ? 1 : 97) {
    const std::string sentence = SentenceFor(whole.substr(0, length));
    ASSERT_THAT(sentence,
                AllOf(HasSubstr("some.exr"), AnyOf(HasSubstr("damaged"), HasSubstr("not an OpenEXR file"))))
        << length;
  }
  EXPECT_THAT(SentenceFor(whole.substr(0, whole.size() - 1)), HasSubstr("damaged"));
}

// Seeded damage: any bytes may change, the answer is a stack or a sentence, never a crash or a huge
// allocation.
TEST_F(ExrFileTest, SurvivesRandomDamage) {
  WriteReflectanceStack(folder_ / "whole.exr", NoisyStack(17, 20));
  const std::string whole = Slurp(folder_ / "whole.exr");
  std::mt19937 random(20250102);
  int refused = 0;
  constexpr int kTrials = 1500;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::string damaged = whole;
    const std::size_t reach = trial % 2 ? damaged.size() : 700;  // every second one hits the header
    for (int change = 0; change <= trial % 5; ++change) {
      damaged[random() % reach] = static_cast<char>(random());
    }
    const auto path = folder_.Write("damaged.exr", damaged);
    try {
      const ReflectanceStack stack = ReadReflectanceStack(path);
      ASSERT_LE(stack.width(), kLargestImageSide);
    } catch (const InputError& error) {
      ++refused;
      ASSERT_THAT(error.what(), HasSubstr("damaged.exr"));
    }
  }
  EXPECT_GT(refused, kTrials / 4);
}

// Foreign files by their first bytes (PNG specification 5.2, TIFF 6.0), and a text.
TEST_F(ExrFileTest, NamesAForeignFile) {
  for (const std::string& bytes : {std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16), std::string("II*\0", 4),
                                   std::string("wavelength,reflectance\n450,0.5\n"), std::string()}) {
    EXPECT_THAT(SentenceFor(bytes), HasSubstr("some.exr is not an OpenEXR file"));
  }
}

// "OpenEXR File Layout", version field: bit 11 is deep data, bit 12 several parts; format version 2.
TEST_F(ExrFileTest, NamesKindsThatItDoesNotRead) {
  EXPECT_THAT(SentenceFor(Plain().Flags(0x1000).Build()), HasSubstr("several parts"));
  EXPECT_THAT(SentenceFor(Plain().Flags(0x800).Build()), HasSubstr("deep"));
  std::string other = Plain().Build();
  other[4] = 3;
  EXPECT_THAT(SentenceFor(other), HasSubstr("version 3"));
}

// Sizes that no patch has are refused by the number, before anything of that size is allocated.
TEST_F(ExrFileTest, RefusesHostileSizes) {
  EXPECT_THAT(SentenceFor(Plain().ClaimSize(2000000000, 2000000000).Build()),
              HasSubstr("2000000000 x 2000000000"));
  EXPECT_THAT(SentenceFor(Plain().ClaimSize(16385, 4).Build()), HasSubstr("1 to 16384 pixels a side"));
  EXPECT_THAT(SentenceFor(Plain().ClaimSize(-5, 4).Build()), HasSubstr("-5 x 4"));
  EXPECT_THAT(SentenceFor(Plain().ClaimSize(16384, 16384).Build()), HasSubstr("promises more pixels"));
  EXPECT_THAT(SentenceFor(Plain().Origin(2147483600, 0).ClaimSize(100, 3).Build()), HasSubstr("some.exr"));
  ExrBuilder many(1, 1);
  for (int i = 0; i < 5000; ++i) {
    many.Channel("T." + std::to_string(350 + i * 0.1) + "nm", ExrType::kFloat, [](int, int) { return 0.5; });
  }
  EXPECT_THAT(SentenceFor(many.Build()), HasSubstr("at most 4096"));
}

// An attribute that claims two gigabytes in a file of a few hundred bytes.
TEST_F(ExrFileTest, RefusesAnAttributeLongerThanTheFile) {
  std::string bytes = Plain().Text("comments", "short").Build();
  const std::size_t at = bytes.find("string") + 7;
  bytes.replace(at, 4, "\xff\xff\xff\x7f");
  EXPECT_THAT(SentenceFor(bytes), HasSubstr("longer than the file"));
}

// The plane is found by its name; the wanted ones only.
TEST_F(ExrFileTest, ReadsOnlyWhatIsWanted) {
  const auto path =
      folder_.Write("some.exr", Plain().Channel("x", ExrType::kFloat, [](int, int) { return 2.0; }).Build());
  const ExrImage image = ReadExr(path, [](const std::string& name) { return name == "x"; });
  ASSERT_EQ(image.planes.size(), 1u);
  EXPECT_EQ(image.Find("x")->operator()(3, 2), 2.0f);
  EXPECT_EQ(image.Find("T.450,000000nm"), nullptr);
  EXPECT_EQ(image.channels.size(), 2u);
}

}  // namespace
}  // namespace dermap
