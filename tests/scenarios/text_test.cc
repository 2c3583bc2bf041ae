#include "scenarios/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenarios/error.h"

namespace lacuna {
namespace {

TEST(Text, PrintableEscapesControlCharactersAndBytesThatAreNoText) {
  EXPECT_EQ(printable("a\nb\x1b[31m"), "a\\nb\\x1b[31m");
  EXPECT_EQ(printable(std::string("\0\xff", 2)), "\\x00\\xff");
  EXPECT_EQ(printable("\xc2\x85"), "\\xc2\\x85") << "next-line control";
  EXPECT_EQ(printable("Größe"), "Größe");
}

TEST(Text, QuotedIsCutAtItsLimit) {
  EXPECT_EQ(quoted("abcdef", 3), "\"abc...\"");
  EXPECT_EQ(quoted("abc", 3), "\"abc\"");
  std::string lvalue = "x";
  EXPECT_EQ(quoted(lvalue), "\"x\"");
}

TEST(Text, FindsTheFirstByteThatIsNoUtf8) {
  EXPECT_EQ(find_invalid_utf8("ok"), std::string::npos);
  EXPECT_EQ(find_invalid_utf8("a\xc0\x80"), 1u) << "overlong";
  EXPECT_EQ(find_invalid_utf8("\xed\xa0\x80"), 0u) << "surrogate";
  EXPECT_EQ(find_invalid_utf8("\xf4\x90\x80\x80"), 0u) << "beyond U+10FFFF";
  EXPECT_EQ(find_invalid_utf8("ab\xe2\x82"), 2u) << "cut";
  EXPECT_EQ(find_invalid_utf8(std::string_view("a\0", 2)), 1u);
}

TEST(Text, ParseNumberTakesWholeDecimalNumbersOnly) {
  EXPECT_EQ(parse_number("-1.5e3"), -1500.0);
  EXPECT_EQ(parse_number("+2"), 2.0);
  EXPECT_EQ(parse_number(".5"), 0.5);
  EXPECT_EQ(parse_number("5."), 5.0);
  EXPECT_TRUE(std::isnan(*parse_number("nan")));
  for (const char* bad : {"", "+", "-", "1.5x", "1_000", "0x10", "1 2", "+-1", "abc", "e5", "."})
    EXPECT_FALSE(parse_number(bad)) << bad;
}

TEST(Text, ParseNumberSendsOverflowToInfinityAndUnderflowToZero) {
  EXPECT_EQ(parse_number("1e999"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("-1e999"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("1e-999"), 0.0);
  EXPECT_EQ(parse_number("0." + std::string(400, '0') + "1"), 0.0);
  EXPECT_EQ(parse_number(std::string(400, '9')), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number(std::string(400, '9') + ".5"), std::numeric_limits<double>::infinity());
}

TEST(Text, FormatNumberReadsBackToTheSameBits) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-310, 6.02e23, -0.0, 3.0}) {
    EXPECT_EQ(*parse_number(format_number(value)), value);
    EXPECT_EQ(std::signbit(*parse_number(format_number(value))), std::signbit(value));
  }
}

}  // namespace
}  // namespace lacuna
