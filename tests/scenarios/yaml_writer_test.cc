#include "scenarios/yaml_writer.h"

#include <gtest/gtest.h>

#include "scenarios/yaml_reader.h"

namespace lacuna {
namespace {

TEST(YamlWriter, PutsShortThingsOnOneLineAndCommentsInAColumn) {
  YamlWriter yaml(20);
  yaml.remark("first\nsecond").map().put("name", "arm").put("gravity", {0.0, -9.81});
  yaml.comment("m/s^2").blank_line().key("joints").comment("all").map();
  yaml.key("a").short_map().put("model", "x").put("bounds", {1.0, 2.0}).end().comment("beyond").remark("alone");
  yaml.key("b").short_list().short_map().put("k", 1e-5).end().end().end();
  yaml.key("files").list().value("a.csv").value("b c").end();
  EXPECT_EQ(yaml.end().str(),
            "# first\n# second\nname: arm\ngravity: [0, -9.81]  # m/s^2\n\njoints:             # all\n"
            "  a: {model: x, bounds: [1, 2]}  # beyond\n# alone\n  b: [{k: 1e-05}]\nfiles:\n  - a.csv\n  - \"b c\"");
}

TEST(YamlWriter, WhatIsWrittenReadsBackAsTheSameText) {
  for (const std::string text : {"plain",
                                 "true",
                                 "no",
                                 "null",
                                 "1.5",
                                 "-",
                                 "- a",
                                 "a: b",
                                 "a #b",
                                 "",
                                 " x ",
                                 "\"q\"",
                                 "b\\s",
                                 "[a]",
                                 "{a}",
                                 "&a",
                                 "*a",
                                 "!t",
                                 "|",
                                 ">",
                                 "%d",
                                 "@x",
                                 "`y`",
                                 "line\nline",
                                 "tab\t",
                                 "\x01\x1f\x7f",
                                 "\xc3\xa9\xe2\x82\xac",
                                 "\xc2\x85\xe2\x80\xa8\xef\xbb\xbf",
                                 "---",
                                 "...",
                                 "?",
                                 "a,b",
                                 "#"}) {
    YamlWriter yaml;
    yaml.map().put("key", text).key("in_line").short_list().value(text).end();
    yaml.put(text.empty() ? "x" : text + ".", text);
    const YamlNode root = parse_yaml(yaml.end().str() + "\n", "t.yaml");
    ASSERT_EQ(root.items.size(), 3u) << text;
    EXPECT_EQ(root.items[0].text, text);
    EXPECT_EQ(root.items[1].items.at(0).text, text);
    EXPECT_EQ(root.items[2].text, text);
    EXPECT_EQ(root.keys[2], text.empty() ? "x" : text + ".");
    EXPECT_EQ(root.items[0].quoted, text != "plain") << text;
  }
}

TEST(YamlWriter, RemarksMayStandAnywhereBetweenEntries) {
  YamlWriter yaml;
  yaml.map().remark("head").put("a", 1.0).key("b").map().remark("first").put("c", 2.0).remark("last").end();
  yaml.blank_line().remark("between").key("d").list().remark("none yet").value("e").remark("tail").end();
  const std::string text = yaml.end().str() + "\n";
  EXPECT_EQ(text, "# head\na: 1\nb:\n# first\n  c: 2\n# last\n\n# between\nd:\n# none yet\n  - e\n# tail\n");
  const YamlNode root = parse_yaml(text, "t.yaml");
  EXPECT_EQ(root.keys, (std::vector<std::string>{"a", "b", "d"}));
}

TEST(YamlWriter, UnfinishedTextIsRefused) {
  YamlWriter yaml;
  yaml.list().value("a");
  EXPECT_THROW(yaml.str(), std::logic_error);
  yaml.end();
  EXPECT_EQ(yaml.str(), "- a");
  EXPECT_THROW(yaml.end(), std::logic_error);
}

}  // namespace
}  // namespace lacuna
