#include "reports/html.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace lacuna {
namespace {

std::vector<std::uint8_t> bytes(std::string_view any) { return {any.begin(), any.end()}; }

TEST(Escape, MarkupBecomesText) {
  EXPECT_EQ(escape("<script>alert(\"x\" & 'y')</script>"),
            "&lt;script&gt;alert(&quot;x&quot; &amp; &#39;y&#39;)&lt;/script&gt;");
}

TEST(Escape, KeepsUtf8AndReplacesWhatIsNot) {
  EXPECT_EQ(escape("\u03c4 = 3 \u00b1 1"), "\u03c4 = 3 \u00b1 1");
  EXPECT_EQ(escape("a\xff"
                   "b\xc3"),
            "a\ufffd"
            "b\ufffd");
  EXPECT_EQ(escape(std::string_view("a\0b\x01"
                                    "c",
                                    5)),
            "a\ufffd"
            "b\ufffd"
            "c");
}

TEST(Base64, MatchesTheVectorsOfRfc4648) {
  EXPECT_EQ(base64(bytes("")), "");
  EXPECT_EQ(base64(bytes("f")), "Zg==");
  EXPECT_EQ(base64(bytes("fo")), "Zm8=");
  EXPECT_EQ(base64(bytes("foo")), "Zm9v");
  EXPECT_EQ(base64(bytes("foobar")), "Zm9vYmFy");
  EXPECT_EQ(base64(std::vector<std::uint8_t>{0xff, 0xfe, 0xfd}), "//79");
}

TEST(Table, RefusesRowsOfAnotherWidth) {
  Table table({{"a"}, {"b"}});
  EXPECT_THROW(table.row({text("1")}), std::invalid_argument);
}

TEST(Table, TitlesAreEscaped) {
  Table table({{"<b>"}});
  table.row({text("<i>")});
  const std::string markup = table.html().markup;
  EXPECT_EQ(markup.find("<b>"), std::string::npos);
  EXPECT_EQ(markup.find("<i>"), std::string::npos);
}

TEST(Page, LeavesOutEmptySections) {
  Page page("title", "kicker");
  page.section("Empty", Html{});
  page.section("Full", paragraph("body"));
  const std::string out = page.str();
  EXPECT_EQ(out.find(">Empty<"), std::string::npos);
  EXPECT_NE(out.find(">Full<"), std::string::npos);
}

TEST(Page, PictureStandsInsideThePage) {
  EXPECT_NE(
      picture(bytes("foo"), "\"quoted\"").markup.find("alt=\"&quot;quoted&quot;\" src=\"data:image/png;base64,Zm9v\""),
      std::string::npos);
}

}  // namespace
}  // namespace lacuna
