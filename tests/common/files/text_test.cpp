// SPDX-License-Identifier: Apache-2.0
#include "common/files/text.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dermap {
namespace {

// Damerau 1964's four kinds of slips count one each; kitten/sitting is the textbook 3 (Wagner, Fischer 1974's
// method).
TEST(EditDistance, CountsSlips) {
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(EditDistance("slot", "slot"), 0u);
  EXPECT_EQ(EditDistance("slot", "solt"), 1u);
  EXPECT_EQ(EditDistance("slot", "slots"), 1u);
  EXPECT_EQ(EditDistance("slot", "lot"), 1u);
  EXPECT_EQ(EditDistance("slot", "spot"), 1u);
  EXPECT_EQ(EditDistance("", "slot"), 4u);
}

// IEEE 754: the float nearest 0.1 is 0.100000001490116...; the shortest decimal that names it is 0.1.
TEST(DecimalOf, IsTheDecimalThatWasMeant) {
  EXPECT_EQ(DecimalOf(0.1f), 0.1);
  EXPECT_EQ(DecimalOf(450.1f), 450.1);
  EXPECT_EQ(DecimalOf(0.029296875f), 0.029296875);
}

// The shortest text that reads back: no locale, no trailing zeros.
TEST(FormatNumber, IsShort) {
  EXPECT_EQ(FormatNumber(0.1), "0.1");
  EXPECT_EQ(FormatNumber(450.0), "450");
  EXPECT_EQ(FormatNumber(1e300), "1e+300");
}

// Messages are one line and bounded, whatever a hostile file holds.
TEST(Shorten, BoundsAndFlattens) {
  EXPECT_EQ(Shorten("a\nb\x01", 10), "a b ");
  EXPECT_EQ(Shorten("abcdef", 3), "abc...");
  EXPECT_EQ(Join(std::vector<std::string>{"a", "b"}, ", "), "a, b");
}

}  // namespace
}  // namespace dermap
