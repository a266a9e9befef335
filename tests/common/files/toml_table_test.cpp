// SPDX-License-Identifier: Apache-2.0
#include "common/files/toml_table.h"

#include <gmock/gmock.h>

#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class TomlTableTest : public testing::Test {
 protected:
  TomlTable Parse(const std::string& text) { return TomlTable::ReadFile(folder_.Write("some.toml", text)); }
  TemporaryFolder folder_;
};

// TOML 1.0.0: integers, floats, booleans, strings, arrays, tables and arrays of tables.
TEST_F(TomlTableTest, ReadsEveryType) {
  TomlTable table = Parse(
      "exposure_ms = 12.5\niso = 400\nwhole = 3\nopaque = true\nname = \"wheel\"\nregion = [0, 0.5, 1]\n"
      "[geometry]\nwindow_mm = 7.5\n[[slot]]\nslot = 1\n[[slot]]\nslot = 2\n");
  EXPECT_DOUBLE_EQ(table.Number("exposure_ms", 1, 0, 100), 12.5);
  EXPECT_DOUBLE_EQ(table.RequiredNumber("whole", 0, 100), 3.0);
  EXPECT_EQ(table.RequiredInteger("iso", 1, 1000), 400);
  EXPECT_TRUE(table.Boolean("opaque", false));
  EXPECT_EQ(table.RequiredString("name"), "wheel");
  EXPECT_THAT(table.Numbers("region", {}), ElementsAre(0.0, 0.5, 1.0));
  auto geometry = table.Table("geometry");
  ASSERT_TRUE(geometry);
  EXPECT_DOUBLE_EQ(geometry->Number("window_mm", 0, 0, 100), 7.5);
  auto slots = table.Tables("slot");
  ASSERT_EQ(slots.size(), 2u);
  EXPECT_EQ(slots[1].RequiredInteger("slot", 1, 9), 2);
  EXPECT_EQ(table.Tables("slot").size(), 2u) << "asking twice gives the same";
  table.Finish();
}

// What is absent takes the caller's value.
TEST_F(TomlTableTest, FallsBackWhereAKeyIsAbsent) {
  TomlTable table = Parse("");
  EXPECT_DOUBLE_EQ(table.Number("a", 1.5, 0, 2), 1.5);
  EXPECT_EQ(table.Integer("b", 7, 0, 9), 7);
  EXPECT_EQ(table.String("c", "d"), "d");
  EXPECT_FALSE(table.Boolean("e", false));
  EXPECT_THAT(table.Numbers("f", {1.0}), ElementsAre(1.0));
  EXPECT_FALSE(table.Table("g"));
  EXPECT_TRUE(table.Tables("h").empty());
  EXPECT_FALSE(table.Has("a"));
}

// The house's rule: file, line, key, what was found and what was expected.
TEST_F(TomlTableTest, NamesFileLineKeyFoundAndExpected) {
  TomlTable table = Parse("name = 'x'\n\n[camera]\nexposure_ms = \"fast\"\n");
  auto camera = table.Table("camera");
  const std::string sentence = SentenceOf<InputError>([&] { camera->Number("exposure_ms", 1, 0.01, 60000); });
  EXPECT_THAT(sentence, AllOf(HasSubstr("some.toml line 4"), HasSubstr("camera.exposure_ms"),
                              HasSubstr("\"fast\""), HasSubstr("a number from 0.01 to 60000")));
}

// TOML 1.0.0 has inf and nan; a quantity is neither.
TEST_F(TomlTableTest, RejectsNumbersOutOfRangeOrNotFinite) {
  TomlTable table = Parse("a = inf\nb = nan\nc = 3\nd = [1, nan]\ne = 2.0\nf = 9223372036854775807\n");
  for (const char* key : {"a", "b", "c"}) {
    EXPECT_THAT(SentenceOf<InputError>([&] { table.Number(key, 0, 0, 2); }), HasSubstr("from 0 to 2")) << key;
  }
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Numbers("d", {}); }), HasSubstr("holds nan"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Integer("e", 0, 0, 9); }),
              HasSubstr("an integer from 0 to 9"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Integer("f", 0, 0, 9); }), HasSubstr("9223372036854775807"));
}

// Each wrong type is named for what it is.
TEST_F(TomlTableTest, RejectsWrongTypes) {
  TomlTable table = Parse("a = 1\nb = 1979-05-27\nc = [1]\n[d]\n");
  EXPECT_THAT(SentenceOf<InputError>([&] { table.String("a", ""); }), HasSubstr("expected a text in quotes"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Boolean("a", true); }), HasSubstr("expected true or false"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Number("b", 0, 0, 1); }), HasSubstr("a date"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Number("c", 0, 0, 1); }), HasSubstr("a list of 1 value"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Table("a"); }), HasSubstr("[a]"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Tables("c"); }), HasSubstr("[[c]]"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Tables("d"); }), HasSubstr("[[d]]"));
  EXPECT_THAT(SentenceOf<InputError>([&] { table.Numbers("a", {}); }), HasSubstr("a list of numbers"));
}

// The brief example of the design's own words: exposure -> exposure_ms.
TEST_F(TomlTableTest, SuggestsTheNearestKey) {
  const auto sentence_for = [&](const std::string& key) {
    TomlTable table = Parse("\n" + key + " = 1\n");
    table.Number("exposure_ms", 1, 0, 10);
    table.Number("window_mm", 1, 0, 10);
    table.String("camera", "");
    return SentenceOf<InputError>([&] { table.Finish(); });
  };
  EXPECT_THAT(sentence_for("exposure"),
              AllOf(HasSubstr("unknown key 'exposure'"), HasSubstr("some.toml line 2"),
                    HasSubstr("did you mean 'exposure_ms'?")));
  EXPECT_THAT(sentence_for("exposrue_ms"), HasSubstr("did you mean 'exposure_ms'?"));
  EXPECT_THAT(sentence_for("widnow_mm"), HasSubstr("did you mean 'window_mm'?"));
  EXPECT_THAT(sentence_for("brightness"), HasSubstr("known here: camera, exposure_ms, window_mm"));
}

// A missing key is told with the line of the table that lacks it.
TEST_F(TomlTableTest, NamesAMissingKey) {
  TomlTable table = Parse("a = 1\n[[wheel.slot]]\nopaque = true\n");
  auto wheel = table.Table("wheel");
  auto slots = wheel->Tables("slot");
  EXPECT_THAT(SentenceOf<InputError>([&] { slots.at(0).RequiredInteger("slot", 1, 9); }),
              AllOf(HasSubstr("some.toml line 2"), HasSubstr("'wheel.slot[1].slot' is missing")));
}

// Text that is not TOML: the parser's reason with file and line, on one line.
TEST_F(TomlTableTest, NamesTheLineThatIsNotToml) {
  EXPECT_THAT(SentenceOf<InputError>([&] { Parse("a = 1\nb = = 2\n"); }), HasSubstr("some.toml line 2"));
  EXPECT_THAT(SentenceOf<InputError>([&] { Parse(std::string("\x89PNG\r\n\x1a\n\0\0", 10)); }),
              HasSubstr("some.toml line 1"));
  EXPECT_THAT(SentenceOf<InputError>([&] { Parse("a = 1\na = 2\n"); }), HasSubstr("line 2"));
}

}  // namespace
}  // namespace dermap
