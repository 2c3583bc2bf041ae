#include "scenarios/xml_writer.h"

#include <gtest/gtest.h>

namespace lacuna {
namespace {

TEST(XmlWriter, IndentsElementsAndKeepsALineOnItsLine) {
  XmlWriter xml;
  xml.declare().comment("of a -- b").open("robot").set("name", "r");
  xml.line("joint").set("type", "fixed").open("axis").set("xyz", Eigen::Vector3d(0, -1, 0)).close().close();
  xml.open("link").open("mass").set("value", 2.0).close().close().close();
  EXPECT_EQ(xml.str(),
            "<?xml version=\"1.0\"?>\n<!-- of a - - b -->\n<robot name=\"r\">\n"
            "  <joint type=\"fixed\"><axis xyz=\"0 -1 0\"/></joint>\n"
            "  <link>\n    <mass value=\"2\"/>\n  </link>\n</robot>\n");
}

TEST(XmlWriter, KeepsTextInItsQuotesAndNumbersToTheLastBit) {
  XmlWriter xml;
  xml.open("a").set("name", "<'\"&>").set("x", {0.1 + 0.2, -0.0, 1e-300}).close();
  EXPECT_EQ(xml.str(), "<a name=\"&lt;&apos;&quot;&amp;&gt;\" x=\"0.30000000000000004 0 1e-300\"/>\n");
}

}  // namespace
}  // namespace lacuna
