#include "scenarios/yaml_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::input_error;
using testing::HasSubstr;

std::string yaml_refusal(const std::string& text) {
  return input_error([&] { parse_yaml(text, "s.yaml"); });
}

TEST(Yaml, KeepsOrderLinesAndQuotes) {
  const YamlNode tree = parse_yaml("b: 1\na: [x, \"2\"]\n", "s.yaml");
  ASSERT_EQ(tree.keys.size(), 2u);
  EXPECT_EQ(tree.keys[0], "b");
  EXPECT_EQ(tree.items[1].items[1].line, 2);
  EXPECT_TRUE(tree.items[1].items[1].quoted);
}

TEST(Yaml, CursorNamesFileLineAndKey) {
  const YamlNode tree = parse_yaml("a:\n  b:\n    - c: x\n", "s.yaml");
  const YamlCursor leaf = YamlCursor(tree, "s.yaml").at("a").at("b").items()[0].at("c");
  EXPECT_EQ(leaf.where(), "s.yaml:3: a.b[0].c");
  EXPECT_EQ(input_error([&] { leaf.number(); }), "s.yaml:3: a.b[0].c: found \"x\", expected a number");
  EXPECT_EQ(input_error([&] { YamlCursor(tree, "s.yaml").at("a").number(); }),
            "s.yaml:2: a: found a map of 1, expected a number");
}

TEST(Yaml, NumbersAreNumbersOnly) {
  const auto number = [](const std::string& text) {
    const YamlNode tree = parse_yaml("a: " + text, "s.yaml");
    return YamlCursor(tree, "s.yaml").at("a").number();
  };
  EXPECT_EQ(number("1e3"), 1000.0);
  EXPECT_EQ(number("-.5"), -0.5);
  for (const char* bad : {".inf", "-.inf", ".nan", "nan", "inf", "1e999"})
    EXPECT_THAT(input_error([&] { number(bad); }), HasSubstr("expected a finite number")) << bad;
  for (const char* bad : {"\"1\"", "1_000", "0x10", "1 2", "~", "true", "[1]", "{b: 1}", ""})
    EXPECT_THAT(input_error([&] { number(bad); }), HasSubstr("expected a number")) << bad;
}

TEST(Yaml, RefusesWhatHidesOrMultipliesContent) {
  EXPECT_EQ(yaml_refusal("a: 1\nb: 2\na: 3\n"), "s.yaml:3: found the key \"a\" a second time, expected each key once");
  EXPECT_THAT(yaml_refusal("a: &x [1]\nb: 2\n"), HasSubstr("s.yaml:1: found an anchor"));
  EXPECT_THAT(yaml_refusal("a: &x [1]\nb: *x\n"), HasSubstr("an anchor"));
  EXPECT_THAT(yaml_refusal("a: !!python/object x\n"), HasSubstr("s.yaml:1: found the tag"));
  EXPECT_THAT(yaml_refusal("a: !!map {}\n"), HasSubstr("found the tag"));
  EXPECT_THAT(yaml_refusal("a: 1\n---\nb: 2\n"), HasSubstr("a second document"));
  EXPECT_THAT(yaml_refusal("[a]: 1\n"), HasSubstr("a list or map as a key"));
  EXPECT_THAT(yaml_refusal(": 1\n"), HasSubstr("an empty key"));
  EXPECT_THAT(yaml_refusal("a: \xff\n"), HasSubstr("s.yaml:1: found the byte 0xff, expected UTF-8 text"));
}

TEST(Yaml, RefusesBrokenTextWithItsLine) {
  EXPECT_THAT(yaml_refusal("a: 1\nb: [1, 2\n"), testing::StartsWith("s.yaml:"));
  EXPECT_THAT(yaml_refusal("a: 1\n\tb: 2\n"), HasSubstr("broken YAML"));
  EXPECT_THAT(yaml_refusal(""), HasSubstr("no content"));
}

TEST(Yaml, RefusesDeepNestingAtOnce) {
  EXPECT_THAT(yaml_refusal(std::string(500'000, '[')), HasSubstr("s.yaml:1: found"));
  EXPECT_THAT(yaml_refusal(std::string(100, '[') + std::string(100, ']')), HasSubstr("more than 32 levels of nesting"));
  std::string blocks;
  for (int i = 0; i < 300; ++i) blocks += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_THAT(yaml_refusal(blocks), HasSubstr("more than 32 levels of nesting"));
  EXPECT_THAT(yaml_refusal(std::string(kYamlMaxBytes + 1, ' ')), HasSubstr("at most 1048576"));
}

TEST(Yaml, ManyKeysAreNoBurden) {
  std::string text;
  for (int i = 0; text.size() + 16 < kYamlMaxBytes; ++i) text.append("k").append(std::to_string(i)).append(":\n");
  const auto start = std::chrono::steady_clock::now();
  EXPECT_GT(parse_yaml(text, "s.yaml").keys.size(), 100'000u);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST(Yaml, ControlCharactersOfAFileStayInOneLine) {
  const YamlNode tree = parse_yaml("\"a\\nb\\e[31m\": \"x\\ny\"\n", "s.yaml");
  const std::string message = input_error([&] { YamlCursor(tree, "s.yaml").entries()[0].second.number(); });
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_EQ(message.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace lacuna
