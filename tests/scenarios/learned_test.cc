// What was learned, in a scenario: laws and events, read, written back the same, refused by place.
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
  for (const int count : {4, 256}) {
    const ScenarioFolder folder(with_knots(count));
    EXPECT_EQ(load_scenario(folder.file).effects[0].parameters.at("knots"), count);
  }
  for (const int count : {3, 257}) {
    const ScenarioFolder folder(with_knots(count));
    EXPECT_THAT(input_error([&] { load_scenario(folder.file); }),
                HasSubstr(fmt::format("scenario.yaml:23: effects[0].knots: found a list of {}, expected 4 to 256 knots",
                                      count)));
  }
}

TEST(LearnedEffortOfAScenario, TakesKnotsAsEvenAsDecimalsAre) {
  // Thirds in seven digits are off by 1e-7 of their spacing.
  const ScenarioFolder folder(replaced(learned_scenario(), "-0.5, 0, 0.5, 1", "0, 0.3333333, 0.6666667, 1"));
  EXPECT_EQ(load_scenario(folder.file).effects[0].parameters.at("to"), 1.0);
}

class SpoiledCurve : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledCurve, IsRefusedWithFilePlaceFoundAndExpected) { test::expect_refused(learned_scenario(), GetParam()); }

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
        Spoiled{"OverALoad", "over: [q]", "over: [load]",
                "effects[0].over[0]: found \"load\", expected q or v (the joint's position or speed), JOINT.q or "
                "JOINT.v, u (its command) or t (time)"},
        Spoiled{"OverAnUnknownJoint", "over: [q]", "over: [z.q]", "effects[0].over[0]: found \"z.q\", expected q or v"},
        Spoiled{"OverAnotherJointsCommand", "over: [q]", "over: [b.u]", "effects[0].over[0]: found \"b.u\", expected"},
        Spoiled{"OverTwoVariablesInOneListOfKnots", "over: [q]", "over: [q, v]",
                "effects[0].knots: found a list of 4, expected two lists of knots, one a variable"},
        Spoiled{"OverThreeVariables", "over: [q]", "over: [q, v, u]",
                "effects[0].over: found a list of 3, expected one variable or two, as in [q]"},
        Spoiled{"OverNothing", "over: [q]", "over: []",
                "effects[0].over: found a list of 0, expected one variable or two"},
        Spoiled{"OverAsAWord", "over: [q]", "over: q", "effects[0].over: found \"q\", expected a list"},
        Spoiled{"NoOver", "over: [q], ", "", "effects[0]: found no key \"over\""},
        Spoiled{"NoKnots", "knots: [-0.5, 0, 0.5, 1], ", "", "effects[0]: found no key \"knots\""},
        Spoiled{"NoValues", ", values: [0.1, -2, 3, 0]", "", "effects[0]: found no key \"values\""},
        Spoiled{"ParametersBesideIt", "over: [q]", "over: [q], parameters: {value_1: 0.1}",
                "effects[0].parameters: found a map of 1, expected over, knots and values instead"},
        Spoiled{"OfAnotherEffect", "learned_effort", "coulomb_friction", "only learned effects take it"},
        Spoiled{"KnotsOfAnotherEffect", "{effect: learned_effort, where: a, over: [q], ",
                "{effect: coulomb_friction, where: a, ", "effects[0].knots: found a list of 4, expected "},
        Spoiled{"AtAnUnknownJoint", "where: a, over", "where: z, over", "effects[0].where: found the joint \"z\""}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(LearnedEffortOfAScenario, MayBeOfTwoVariablesAndOfAnotherJoint) {
  const std::string two =
      replaced(learned_scenario(), "over: [q], knots: [-0.5, 0, 0.5, 1], values: [0.1, -2, 3, 0]",
               "over: [b.v, q], knots: [[0, 1, 2, 3], [-0.5, 0.5]], values: [[1, 2], [3, 4], [5, 6], [7, 8]]");
  const ScenarioFolder folder(two);
  const Scenario s = load_scenario(folder.file);
  Numbers expected{{"over", 1.0},   {"of", 2.0},      {"from", 0.0}, {"to", 3.0},     {"knots", 4.0},
                   {"over_2", 0.0}, {"from_2", -0.5}, {"to_2", 0.5}, {"knots_2", 2.0}};
  for (int k = 1; k <= 8; ++k) expected[fmt::format("value_{}", k)] = k;
  EXPECT_EQ(s.effects[0].parameters, expected);
  save_scenario(s, folder.path() / "again.yaml");
  EXPECT_EQ(load_scenario(folder.path() / "again.yaml").effects[0].parameters, expected);
}

TEST(LearnedEffortOfAScenario, MayRepeatItself) {
  const ScenarioFolder folder(
      replaced(learned_scenario(), "values: [0.1, -2, 3, 0]", "values: [0.1, -2, 3, 0], period: 2"));
  const Scenario s = load_scenario(folder.file);
  EXPECT_EQ(s.effects[0].parameters.at("period"), 2.0);
  save_scenario(s, folder.path() / "again.yaml");
  EXPECT_EQ(load_scenario(folder.path() / "again.yaml").effects[0].parameters, s.effects[0].parameters);
}

TEST(LearnedEffortOfAScenario, MayBeOnACommandOrAReading) {
  for (const char* name : {"learned_command", "learned_reading"}) {
    const ScenarioFolder folder(replaced(learned_scenario(), "learned_effort", name));
    const Scenario s = load_scenario(folder.file);
    ASSERT_EQ(s.effects.size(), 1u) << name;
    EXPECT_EQ(s.effects[0].effect, name);
    save_scenario(s, folder.path() / "again.yaml");
    EXPECT_EQ(load_scenario(folder.path() / "again.yaml").effects[0].parameters, s.effects[0].parameters);
  }
}

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

const char* const kFriction = "{effect: coulomb_friction, where: a, parameters: {Fc: 3.5}, recordings: [run.csv]}";

/// kScenario with events of every kind in place of its friction, on lines 23 to 25.
std::string eventful_scenario() {
  return replaced(kScenario, kFriction,
                  "{effect: learned_effort, where: a, events: [{recording: run.csv, from: 0.05, to: 0.25, value: -1.5, "
                  "rise: 0.05}]}\n"
                  "  - {effect: learned_command, where: b, events: [{recording: run.csv, from: 0.1, to: 0.2, value: "
                  "0}]}\n"
                  "  - {effect: learned_reading, where: b, events: [{recording: run.csv, from: 0.4, to: 0.6, value: "
                  "0.02}]}");
}

void expect_same_event(const EventSpec& found, const EventSpec& expected) {
  EXPECT_EQ(found.kind, expected.kind);
  EXPECT_EQ(found.joint, expected.joint);
  EXPECT_EQ(found.file, expected.file);
  EXPECT_EQ(found.from, expected.from);
  EXPECT_EQ(found.to, expected.to);
  EXPECT_EQ(found.value, expected.value);
  EXPECT_EQ(found.rise, expected.rise);
}
void expect_same_events(const std::vector<EventSpec>& found, const std::vector<EventSpec>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    SCOPED_TRACE(fmt::format("event {}", k));
    expect_same_event(found[k], expected[k]);
  }
}

TEST(EventsOfAScenario, AreReadWithTheirKindJointRecordingAndTimes) {
  const ScenarioFolder folder(eventful_scenario());
  const Scenario s = load_scenario(folder.file);
  EXPECT_TRUE(s.effects.empty()) << "an event is no part of the machine";
  expect_same_events(s.events, {{EventSpec::Kind::effort, "a", "run.csv", 0.05, 0.25, -1.5, 0.05, ""},
                                {EventSpec::Kind::command, "b", "run.csv", 0.1, 0.2, 0.0, 0.0, ""},
                                {EventSpec::Kind::reading, "b", "run.csv", 0.4, 0.6, 0.02, 0.0, ""}});
  EXPECT_THAT(s.events[0].where, testing::EndsWith("scenario.yaml:23: effects[0].events[0]"));
  EXPECT_THAT(s.events[2].where, testing::EndsWith("scenario.yaml:25: effects[2].events[0]"));
}

TEST(EventsOfAScenario, MayBeSeveralOfOneJointEachOnItsOwnLine) {
  const ScenarioFolder folder(replaced(kScenario, kFriction,
                                       "effect: learned_effort\n    where: b\n    probability: 0.9\n    events:\n"
                                       "      - {recording: run.csv, from: 0.1, to: 0.2, value: 1}\n"
                                       "      - {recording: run.csv, from: 0.4, to: 0.5, value: 2, rise: 0}"));
  const Scenario s = load_scenario(folder.file);
  expect_same_events(s.events, {{EventSpec::Kind::effort, "b", "run.csv", 0.1, 0.2, 1.0, 0.0, ""},
                                {EventSpec::Kind::effort, "b", "run.csv", 0.4, 0.5, 2.0, 0.0, ""}});
  EXPECT_THAT(s.events[1].where, testing::EndsWith("scenario.yaml:28: effects[0].events[1]"));
}

TEST(EventsOfAScenario, StandBesideLawsAndNamedEffects) {
  const std::string law =
      "{effect: learned_effort, where: a, over: [q], knots: [0, 1, 2, 3], values: [0.1, -2, 3, 0]}\n  - ";
  const ScenarioFolder folder(
      replaced(eventful_scenario(), "{effect: learned_effort", law + "{effect: learned_effort"));
  const Scenario s = load_scenario(folder.file);
  ASSERT_EQ(s.effects.size(), 1u);
  EXPECT_EQ(s.effects[0].parameters.at("knots"), 4.0);
  EXPECT_EQ(s.events.size(), 3u);
}

TEST(EventsOfAScenario, MayRiseForHalfOfTheirTimeAndNoLonger) {
  // 0.25 and 0.5 and all that is made of them are exact.
  const std::string all = replaced(eventful_scenario(), "from: 0.05, to: 0.25", "from: 0, to: 0.5");
  const ScenarioFolder half(replaced(all, "rise: 0.05", "rise: 0.25"));
  EXPECT_EQ(load_scenario(half.file).events[0].rise, 0.25);
  const ScenarioFolder longer(replaced(all, "rise: 0.05", "rise: 0.2500001"));
  EXPECT_THAT(input_error([&] { load_scenario(longer.file); }), HasSubstr("effects[0].events[0].rise"));
}

class SpoiledEvent : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledEvent, IsRefusedWithFilePlaceFoundAndExpected) { test::expect_refused(eventful_scenario(), GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Scenario, SpoiledEvent,
    testing::Values(
        Spoiled{"OfAnUnknownRecording", "run.csv, from: 0.05", "gone.csv, from: 0.05",
                "scenario.yaml:23: effects[0].events[0].recording: found \"gone.csv\", expected a file listed under "
                "recordings"},
        Spoiled{"WithoutARecording", "recording: run.csv, from: 0.1,", "from: 0.1,",
                "scenario.yaml:24: effects[1].events[0]: found no key \"recording\""},
        Spoiled{"ToBeforeFrom", "to: 0.25", "to: 0.01",
                "scenario.yaml:23: effects[0].events[0].to: found \"0.01\", expected s, after from (0.05)"},
        Spoiled{"OfNoLength", "to: 0.25", "to: 0.05", "scenario.yaml:23: effects[0].events[0].to: found \"0.05\""},
        Spoiled{"WithoutAnEnd", "to: 0.25, ", "", "scenario.yaml:23: effects[0].events[0]: found no key \"to\""},
        Spoiled{"FromInWords", "from: 0.05", "from: early",
                "scenario.yaml:23: effects[0].events[0].from: found \"early\", expected a number"},
        Spoiled{"WithoutAValue", ", value: -1.5", "", "scenario.yaml:23: effects[0].events[0]: found no key \"value\""},
        Spoiled{"OfAnInfiniteValue", "value: -1.5", "value: -.inf",
                "scenario.yaml:23: effects[0].events[0].value: found \"-.inf\", expected a finite number"},
        Spoiled{"RiseTooLong", "rise: 0.05", "rise: 0.11",
                "scenario.yaml:23: effects[0].events[0].rise: found \"0.11\", expected s, from 0 to half of the event"},
        Spoiled{"RiseBelowNothing", "rise: 0.05", "rise: -0.01",
                "scenario.yaml:23: effects[0].events[0].rise: found \"-0.01\""},
        Spoiled{"RiseOfACommand", "value: 0}", "value: 0, rise: 0.01}",
                "scenario.yaml:24: effects[1].events[0].rise: found \"0.01\", expected nothing: only learned_effort"},
        Spoiled{"RiseOfAReading", "value: 0.02}", "value: 0.02, rise: 0.01}",
                "scenario.yaml:25: effects[2].events[0].rise: found \"0.01\", expected nothing: only learned_effort"},
        Spoiled{"CommandWithoutEvents", ", events: [{recording: run.csv, from: 0.1, to: 0.2, value: 0}]", "",
                "scenario.yaml:24: effects[1]: found no key \"over\""},
        Spoiled{"EffortWithNeitherEventsNorKnots",
                ", events: [{recording: run.csv, from: 0.05, to: 0.25, value: -1.5, rise: 0.05}]", "",
                "scenario.yaml:23: effects[0]: found no key \"over\""},
        Spoiled{"EventsInAWord", "[{recording: run.csv, from: 0.4, to: 0.6, value: 0.02}]", "none",
                "scenario.yaml:25: effects[2].events: found \"none\", expected a list"},
        Spoiled{"EventInAWord", "[{recording: run.csv, from: 0.4, to: 0.6, value: 0.02}]", "[none]",
                "scenario.yaml:25: effects[2].events[0]: found \"none\", expected a map"},
        Spoiled{"UnknownKeyOfAnEvent", "rise: 0.05", "raise: 0.05",
                "scenario.yaml:23: effects[0].events[0].raise: found the unknown key \"raise\""},
        Spoiled{"AtAnUnknownJoint", "where: a, events", "where: z, events",
                "scenario.yaml:23: effects[0].where: found the joint \"z\""},
        Spoiled{"AtTheArm", "where: a, events", "where: arm, events",
                "scenario.yaml:23: effects[0].where: found the joint \"arm\""},
        Spoiled{"WithoutAJoint", "where: a, events", "events", "scenario.yaml:23: effects[0]: found no key \"where\""},
        Spoiled{"BesideOver", "where: a, events", "where: a, over: [q], events",
                "scenario.yaml:23: effects[0].over: found the unknown key \"over\""},
        Spoiled{"BesideKnots", "where: a, events", "where: a, knots: [0, 1, 2, 3], events",
                "scenario.yaml:23: effects[0].knots: found the unknown key \"knots\""},
        Spoiled{"BesideRecordings", "where: a, events", "where: a, recordings: [run.csv], events",
                "scenario.yaml:23: effects[0].recordings: found the unknown key \"recordings\""},
        Spoiled{"OfANamedEffect", "{effect: learned_effort", "{effect: coulomb_friction",
                "scenario.yaml:23: effects[0].events: found the unknown key \"events\""}),
    [](const auto& test) { return std::string(test.param.name); });

/// As a diagnosis finds them: no decimal is short.
std::vector<EventSpec> found_events() {
  return {{EventSpec::Kind::reading, "b", "run.csv", 0.4, 2.0 / 3.0, -1.0 / 7e5, 0.0, ""},
          {EventSpec::Kind::effort, "a", "run.csv", 1.0 / 30.0, 0.1 + 0.2, 1e3 / 7.0, 1.0 / 70.0, ""},
          {EventSpec::Kind::effort, "b", "run.csv", 0.1, 0.2, 1.0 / 3.0, 0.0, ""},
          {EventSpec::Kind::command, "a", "run.csv", 0.1, 0.2, -0.0, 0.0, ""},
          {EventSpec::Kind::command, "b", "run.csv", 0.1, 0.2, 1.0 / 9.0, 0.0, ""}};
}

TEST(EventsOfAScenario, AreSavedToTheSameEventsInTheSameOrder) {
  const ScenarioFolder folder;
  Scenario original = load_scenario(folder.file);
  original.events = found_events();
  save_scenario(original, folder.path() / "again.yaml");
  const Scenario again = load_scenario(folder.path() / "again.yaml");
  expect_same_events(again.events, found_events());
  ASSERT_EQ(again.effects.size(), 1u);
  EXPECT_EQ(again.effects[0].effect, "coulomb_friction");
  // What was read is written once more to the same text.
  save_scenario(again, folder.path() / "once_more.yaml");
  const auto text = [&](const char* name) {
    std::ifstream in(folder.path() / name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(text("once_more.yaml"), text("again.yaml"));
}

TEST(EventsOfAScenario, GoWithTheirRecordingToANewFolder) {
  const ScenarioFolder folder;
  const test::TemporaryFolder elsewhere;
  Scenario original = load_scenario(folder.file);
  original.events = found_events();
  save_scenario(original, elsewhere.path() / "moved.yaml");
  const Scenario moved = load_scenario(elsewhere.path() / "moved.yaml");
  ASSERT_EQ(moved.events.size(), found_events().size());
  EXPECT_NE(moved.recordings[0].file, "run.csv");
  for (const EventSpec& event : moved.events) EXPECT_EQ(event.file, moved.recordings[0].file);
}

TEST(EventsOfAScenario, SayTheirKindAsAScenarioDoes) {
  EXPECT_STREQ(to_string(EventSpec::Kind::effort), "learned_effort");
  EXPECT_STREQ(to_string(EventSpec::Kind::command), "learned_command");
  EXPECT_STREQ(to_string(EventSpec::Kind::reading), "learned_reading");
}

}  // namespace
}  // namespace lacuna
