// A learned law in a scenario: read to the numbers that the plant takes, written back the same, refused by place.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/scenario.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::input_error;
using test::kScenario;
using test::replaced;
using test::ScenarioFolder;
using test::Spoiled;
using testing::AllOf;
using testing::HasSubstr;

/// kScenario with a curve at joint a in place of its friction, on the same line.
std::string learned_scenario() {
  return replaced(kScenario, "{effect: coulomb_friction, where: a, parameters: {Fc: 3.5}, recordings: [run.csv]}",
                  "{effect: learned_effort, where: a, over: [q], knots: [-0.5, 0, 0.5, 1], values: [0.1, -2, 3, 0]}");
}

/// "0, 1, 2" up to `count` numbers.
std::string counted(int count) {
  std::string out;
  for (int k = 0; k < count; ++k) out += (k > 0 ? ", " : "") + std::to_string(k);
  return out;
}
std::string with_knots(int count) {
  return replaced(replaced(learned_scenario(), "-0.5, 0, 0.5, 1", counted(count)), "0.1, -2, 3, 0", counted(count));
}

using Numbers = std::map<std::string, double>;

TEST(LearnedEffortOfAScenario, IsReadToTheNumbersThatThePlantTakes) {
  const ScenarioFolder position(learned_scenario());
  const Scenario s = load_scenario(position.file);
  ASSERT_EQ(s.effects.size(), 1u);
  EXPECT_EQ(s.effects[0].effect, "learned_effort");
  EXPECT_EQ(s.effects[0].place, "a");
  EXPECT_THAT(s.effects[0].where, testing::EndsWith("scenario.yaml:23: effects[0]"));
  Numbers expected{{"over", 0.0},    {"from", -0.5},    {"to", 1.0},      {"knots", 4.0},
                   {"value_1", 0.1}, {"value_2", -2.0}, {"value_3", 3.0}, {"value_4", 0.0}};
  EXPECT_EQ(s.effects[0].parameters, expected);
  const ScenarioFolder speed(replaced(learned_scenario(), "[q]", "[v]"));
  expected["over"] = 1.0;
  EXPECT_EQ(load_scenario(speed.file).effects[0].parameters, expected);
}

TEST(LearnedEffortOfAScenario, MayHaveItsFewestAndItsMostKnotsAndNoOthers) {
  for (const int count : {4, 128}) {
    const ScenarioFolder folder(with_knots(count));
    EXPECT_EQ(load_scenario(folder.file).effects[0].parameters.at("knots"), count);
  }
  for (const int count : {3, 129}) {
    const ScenarioFolder folder(with_knots(count));
    EXPECT_THAT(input_error([&] { load_scenario(folder.file); }),
                HasSubstr(fmt::format("scenario.yaml:23: effects[0].knots: found a list of {}, expected 4 to 128 knots",
                                      count)));
  }
}

TEST(LearnedEffortOfAScenario, TakesKnotsAsEvenAsDecimalsAre) {
  // Thirds in seven digits are off by 1e-7 of their spacing.
  const ScenarioFolder folder(replaced(learned_scenario(), "-0.5, 0, 0.5, 1", "0, 0.3333333, 0.6666667, 1"));
  EXPECT_EQ(load_scenario(folder.file).effects[0].parameters.at("to"), 1.0);
}

class SpoiledCurve : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledCurve, IsRefusedWithFilePlaceFoundAndExpected) {
  const ScenarioFolder folder(replaced(learned_scenario(), GetParam().from, GetParam().to));
  const std::string message = input_error([&] { load_scenario(folder.file); });
  EXPECT_THAT(message, AllOf(HasSubstr("scenario.yaml:23: effects[0]"), HasSubstr(GetParam().message)));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Scenario, SpoiledCurve,
    testing::Values(
        Spoiled{"UnevenKnots", "[-0.5, 0, 0.5, 1]", "[-0.5, 0.1, 0.5, 1]",
                "effects[0].knots[1]: found \"0.1\", expected knots at even distances"},
        Spoiled{"LastKnotOffByAHundredthOfASpacing", "[-0.5, 0, 0.5, 1]", "[-0.5, 0, 0.5, 1.005]",
                ": found \"0\", expected knots at even distances"},
        Spoiled{"KnotsThatFall", "[-0.5, 0, 0.5, 1]", "[1, 0.5, 0, -0.5]",
                "effects[0].knots: found a list of 4, expected knots in increasing order"},
        Spoiled{"KnotsAtOnePlace", "[-0.5, 0, 0.5, 1]", "[1, 1, 1, 1]", "expected knots in increasing order"},
        Spoiled{"FewerValuesThanKnots", "[0.1, -2, 3, 0]", "[0.1, -2, 3]",
                "effects[0].values: found a list of 3, expected 4 values, one a knot"},
        Spoiled{"MoreValuesThanKnots", "[0.1, -2, 3, 0]", "[0.1, -2, 3, 0, 1]",
                "effects[0].values: found a list of 5, expected 4 values, one a knot"},
        Spoiled{"ValueThatIsNoNumber", "[0.1, -2, 3, 0]", "[0.1, -2, .nan, 0]",
                "effects[0].values[2]: found \".nan\", expected a finite number"},
        Spoiled{"KnotInWords", "[-0.5, 0, 0.5, 1]", "[-0.5, zero, 0.5, 1]",
                "effects[0].knots[1]: found \"zero\", expected a number"},
        Spoiled{"OverTheCommand", "over: [q]", "over: [u]",
                "effects[0].over[0]: found \"u\", expected q (the joint's position) or v (its speed)"},
        Spoiled{"OverTwoVariables", "over: [q]", "over: [q, v]",
                "effects[0].over: found a list of 2, expected one variable, [q] or [v]"},
        Spoiled{"OverNothing", "over: [q]", "over: []", "effects[0].over: found a list of 0, expected one variable"},
        Spoiled{"OverAsAWord", "over: [q]", "over: q", "effects[0].over: found \"q\", expected a list"},
        Spoiled{"NoOver", "over: [q], ", "", "effects[0]: found no key \"over\""},
        Spoiled{"NoKnots", "knots: [-0.5, 0, 0.5, 1], ", "", "effects[0]: found no key \"knots\""},
        Spoiled{"NoValues", ", values: [0.1, -2, 3, 0]", "", "effects[0]: found no key \"values\""},
        Spoiled{"ParametersBesideIt", "over: [q]", "over: [q], parameters: {value_1: 0.1}",
                "effects[0].parameters: found a map of 1, expected over, knots and values instead"},
        Spoiled{"OfAnotherEffect", "learned_effort", "coulomb_friction", "only learned_effort takes it"},
        Spoiled{"KnotsOfAnotherEffect", "{effect: learned_effort, where: a, over: [q], ",
                "{effect: coulomb_friction, where: a, ", "effects[0].knots: found a list of 4, expected "},
        Spoiled{"AtAnUnknownJoint", "where: a, over", "where: z, over", "effects[0].where: found the joint \"z\""}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(LearnedEffortOfAScenario, IsSavedToTheSameNumbers) {
  const ScenarioFolder folder(learned_scenario());
  Scenario original = load_scenario(folder.file);
  // As a diagnosis finds them: 64 knots over a range, values and ends of which no decimal is short.
  Numbers& found = original.effects[0].parameters;
  found = {{"over", 1.0}, {"from", -1.0 / 3.0 - 1e-9}, {"to", 2.0 / 7.0}, {"knots", 64.0}};
  for (int k = 1; k <= 64; ++k) found[fmt::format("value_{}", k)] = 1e-3 / (k - 20.5);
  original.effects[0].recordings = {"run.csv"};
  save_scenario(original, folder.path() / "again.yaml");
  const Scenario again = load_scenario(folder.path() / "again.yaml");
  ASSERT_EQ(again.effects.size(), 1u);
  EXPECT_EQ(again.effects[0].effect, "learned_effort");
  EXPECT_EQ(again.effects[0].place, "a");
  EXPECT_EQ(again.effects[0].parameters, found);
  EXPECT_EQ(again.effects[0].recordings, original.effects[0].recordings);
}

}  // namespace
}  // namespace lacuna
