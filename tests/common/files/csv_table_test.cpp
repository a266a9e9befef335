// SPDX-License-Identifier: Apache-2.0
// Comma-separated text as spreadsheets and people write it, and what is refused by line.
#include "common/files/csv_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Csv : public ::testing::Test {
 protected:
  CsvTable Read(const std::string& text) {
    WriteFileAtomically(path_, std::string_view(text));
    return ReadCsv(path_);
  }
  std::string Refusal(const std::string& text) {
    return SentenceOf<InputError>([&] { Read(text); });
  }
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "grid.csv";
};

// RFC 4180, and what Excel adds: a byte order mark and CRLF; # comments are ours.
TEST_F(Csv, TakesWhatSpreadsheetsWrite) {
  const CsvTable table =
      Read("\xEF\xBB\xBF# notes, with a comma\r\n\r\n a , \"b\"\r\n1,\"2,\"\"3\"\r\n\r\n# end\r\n4,5");
  EXPECT_THAT(table.header.fields, ElementsAre("a", "b"));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_THAT(table.rows[0].fields, ElementsAre("1", "2,\"3"));
  EXPECT_EQ(table.rows[0].line, 4u);
  EXPECT_THAT(table.rows[1].fields, ElementsAre("4", "5"));
  EXPECT_EQ(table.rows[1].line, 7u);
}

// A row that does not fit the header is named by the line that an editor shows.
TEST_F(Csv, NamesTheLineOfWhatIsWrong) {
  EXPECT_THAT(Refusal("a,b\n1,2\n1,2,3\n"), HasSubstr("line 3: found 3 fields, expected 2"));
  EXPECT_THAT(Refusal("a,b\n1\n"), HasSubstr("line 2: found 1 fields"));
  EXPECT_THAT(Refusal("a,b\n1,\"2\n"), HasSubstr("line 2: a quote is not closed"));
  EXPECT_THAT(Refusal("a,b\n\"1\"x,2\n"), HasSubstr("line 2: expected a comma"));
  EXPECT_THAT(Refusal(std::string("a,b\n1,\0002\n", 9)), HasSubstr("line 2"));
  EXPECT_THAT(Refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(Refusal("# only a comment\n"), HasSubstr("is empty"));
}

// What is written reads back as it was; source: RFC 4180.
TEST_F(Csv, FieldsSurviveWritingAndReading) {
  for (const std::string text : {"plain", "a,b", "say \"so\"", " spaces ", ""}) {
    const CsvTable table = Read("x,y\n" + CsvField(text) + ",1\n");
    EXPECT_EQ(table.rows.at(0).fields.at(0), text);
  }
}

// Numbers are decimal, finite and whole fields.
TEST(CsvNumber, RefusesWhatIsNoNumber) {
  EXPECT_EQ(CsvNumber("here", "x", "2.5e-1"), 0.25);
  EXPECT_EQ(CsvNumber("here", "x", "+3"), 3.0);
  for (const char* text : {"", "nan", "inf", "-inf", "1e999", "0x10", "1 2", "1;2", "+-1", "one"}) {
    EXPECT_THROW(CsvNumber("here", "x", text), InputError) << text;
  }
}

}  // namespace
}  // namespace dermap
