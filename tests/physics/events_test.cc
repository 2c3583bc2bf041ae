// What happened once, put into a segment: its course over intervals and samples, and where it may not stand.
#include "physics/events.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/physics/event_plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kEventRoundings = 1e-12;  // s, of a hundred sums and differences of some seconds

/// Samples 5 to 35 ms apart.
std::vector<double> uneven_samples(std::uint64_t seed) {
  Noise random(seed);
  std::vector<double> out{0.0};
  while (out.size() < 60) out.push_back(out.back() + 0.005 + 0.03 * random.uniform());
  return out;
}

/// Two joints, to which another command is given at every sample.
Segment eventless_segment(const std::vector<double>& time) {
  auto track = std::make_shared<CommandTrack>();
  track->time = time;
  track->value.resize(2);
  for (std::size_t k = 0; k < time.size(); ++k) {
    track->value[0].push_back(1.0 + static_cast<double>(k));
    track->value[1].push_back(-1.0 - static_cast<double>(k));
  }
  Segment out;
  out.count = time.size();
  out.commands = track;
  out.q0 = {0.3, -0.4};
  out.v0 = {0.0, 0.0};
  return out;
}

/// Of a unit event over the segment, s.
double time_integral(const Segment& segment, const Event& event) {
  const std::vector<double> means = mean_of_intervals(segment, event);
  EXPECT_EQ(means.size(), segment.count - 1);
  double out = 0.0;
  for (std::size_t k = 0; k < means.size(); ++k) out += means[k] * (segment.time(k + 1) - segment.time(k));
  return out;
}

TEST(EventCourse, HoldsAllOfItsSizeWhereverItsEdgesFallBetweenSamples) {
  Noise random(3);
  for (std::uint64_t draw = 1; draw <= 200; ++draw) {
    const Segment segment = eventless_segment(uneven_samples(draw));
    const double last = segment.time(segment.count - 1);
    const double begin = last * random.uniform(), end = begin + (last - begin) * random.uniform();
    const double rise = draw % 2 == 0 ? 0.0 : 0.5 * (end - begin) * random.uniform();
    EXPECT_NEAR(time_integral(segment, push_on(0, begin, end, 1.0, rise)), end - begin - rise, kEventRoundings)
        << "draw " << draw;
    EXPECT_NEAR(time_integral(segment, push_on(0, begin, end, 1.0, 0.5 * (end - begin))), 0.5 * (end - begin),
                kEventRoundings)
        << "a triangle, draw " << draw;
  }
}

TEST(EventCourse, OfABoxIsTheShareOfAnIntervalThatItCovers) {
  const Segment segment = eventless_segment(clock(1.0, 0.1));
  const std::vector<double> expected{0.0, 0.0, 0.5, 1.0, 0.7, 0.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_LT(worst_difference(mean_of_intervals(segment, push_on(0, 0.25, 0.47, 1.0)), expected), kEventRoundings);
}

TEST(EventCourse, RisesAndFallsEvenlyWithinItsTime) {
  const Segment segment = eventless_segment(clock(1.0, 0.1));
  const std::vector<double> expected{0.0, 0.0, 0.25, 0.75, 1.0, 1.0, 0.75, 0.25, 0.0, 0.0};
  EXPECT_LT(worst_difference(mean_of_intervals(segment, push_on(0, 0.2, 0.8, 1.0, 0.2)), expected), kEventRoundings);
}

TEST(EventCourse, CountsInTheSegmentOnly) {
  const Segment segment = eventless_segment(clock(1.0, 0.1));
  EXPECT_NEAR(time_integral(segment, push_on(0, -1.0, 0.35, 1.0)), 0.35, kEventRoundings);
  EXPECT_NEAR(time_integral(segment, push_on(0, 0.35, 9.0, 1.0)), 0.65, kEventRoundings);
  EXPECT_NEAR(time_integral(segment, push_on(0, -1.0, 9.0, 1.0)), 1.0, kEventRoundings);
  // Half of the rise lies before the start.
  EXPECT_NEAR(time_integral(segment, push_on(0, -0.1, 0.5, 1.0, 0.2)), 0.075 + 0.2 + 0.1, kEventRoundings);
}

TEST(EventCourse, AtSamplesBeginsWithItsFirstAndStopsBeforeItsEnd) {
  const Segment segment = eventless_segment(uneven_samples(1));
  const std::vector<double> values = value_at_samples(segment, slip_of(0, segment.time(3), segment.time(7), 2.0));
  ASSERT_EQ(values.size(), segment.count);
  for (std::size_t k = 0; k < values.size(); ++k) EXPECT_EQ(values[k], k >= 3 && k < 7 ? 1.0 : 0.0) << k;
}

TEST(AddEvent, OutsideOfASegmentChangesNothing) {
  const Segment before = eventless_segment(uneven_samples(1));
  const double last = before.time(before.count - 1);
  for (const auto& [begin, end] : {std::pair(-2.0, -1.0), std::pair(-1.0, 0.0), std::pair(last + 0.1, last + 1.0)})
    for (const Event& event :
         {push_on(0, begin, end, 3.0), command_of(0, begin, end, 3.0), slip_of(0, begin, end, 3.0)}) {
      Segment after = before;
      add_event(after, event);
      EXPECT_EQ(after.pushes, nullptr);
      EXPECT_EQ(after.slips, nullptr);
      EXPECT_EQ(after.commands->value, before.commands->value);
      EXPECT_EQ(after.q0, before.q0);
    }
}

TEST(AddEvent, OfACommandStandsFromItsFirstSampleToBeforeItsEnd) {
  const Segment before = eventless_segment(uneven_samples(1));
  Segment after = before;
  add_event(after, command_of(1, before.time(3), before.time(7), 7.5));
  for (std::size_t k = 0; k < before.count; ++k)
    EXPECT_EQ(after.commands->value[1][k], k >= 3 && k < 7 ? 7.5 : before.commands->value[1][k]) << k;
  EXPECT_EQ(after.commands->value[0], before.commands->value[0]);
  EXPECT_EQ(after.commands->time, before.commands->time);
}

TEST(AddEvent, AddsToThoseThatThereAre) {
  const Segment segment = eventless_segment(clock(1.0, 0.1));
  Segment one = segment, other = segment, both = segment;
  add_event(one, push_on(1, 0.2, 0.5, 3.0)), add_event(other, push_on(1, 0.4, 0.9, -1.0, 0.1));
  add_event(both, push_on(1, 0.2, 0.5, 3.0)), add_event(both, push_on(1, 0.4, 0.9, -1.0, 0.1));
  ASSERT_NE(both.pushes, nullptr);
  for (std::size_t k = 0; k + 1 < segment.count; ++k) {
    EXPECT_EQ((*both.pushes)[1][k], (*one.pushes)[1][k] + (*other.pushes)[1][k]) << k;
    EXPECT_EQ((*both.pushes)[0][k], 0.0) << k;
  }
  add_event(both, slip_of(0, -1.0, 0.5, 0.25)), add_event(both, slip_of(0, -1.0, 0.3, 0.5));
  EXPECT_EQ((*both.slips)[0][0], 0.75);
  EXPECT_EQ((*both.slips)[0][4], 0.25);
  EXPECT_EQ(both.q0[0], segment.q0[0] - 0.25 - 0.5);
}

TEST(AddEvent, LeavesSegmentsThatSharedTheirDataAsTheyWere) {
  Segment first = eventless_segment(clock(1.0, 0.1));
  const CommandTrack commands = *first.commands;
  add_event(first, push_on(0, 0.2, 0.5, 3.0)), add_event(first, slip_of(0, 0.2, 0.5, 0.1));
  const auto pushes = *first.pushes, slips = *first.slips;
  Segment second = first;
  for (const Event& event : {push_on(0, 0.3, 0.7, 1.0), command_of(0, 0.3, 0.7, -5.0), slip_of(0, -1.0, 0.7, 0.2)})
    add_event(second, event);
  EXPECT_EQ(*first.pushes, pushes);
  EXPECT_EQ(*first.slips, slips);
  EXPECT_EQ(first.commands->value, commands.value);
  EXPECT_EQ(first.q0, (std::vector<double>{0.3, -0.4}));
  EXPECT_NE(*second.pushes, pushes) << "nothing was tested";
}

constexpr double kLate = 12.34;  // s

/// The block's recording on a clock that begins late.
Scenario late_scenario() {
  SprungBlock block;
  for (double& t : block.drive.time) t += kLate;
  return driven_scenario(block.scenario.robot, block.scenario.actuators, block.drive, block.start);
}

std::vector<Event> one_of_each_kind(const Segment& segment) {
  return {push_on(0, 0.513, 0.987, 3.0, 0.1), command_of(0, segment.time(120), segment.time(150), 0.0),
          slip_of(0, segment.time(33), segment.time(77), 0.02)};
}

void expect_same_happening(const Segment& found, const Segment& expected) {
  ASSERT_NE(found.pushes, nullptr);
  ASSERT_NE(found.slips, nullptr);
  // N, of an edge that a clock of some ten seconds rounds: its 2e-15 s over a sample of 0.01 s.
  EXPECT_LT(worst_difference((*found.pushes)[0], (*expected.pushes)[0]), 1e-11);
  EXPECT_TRUE(same_bits(*found.slips, *expected.slips));
  EXPECT_TRUE(same_bits(found.commands->value, expected.commands->value));
  EXPECT_TRUE(same_bits(found.q0, expected.q0));
}

TEST(EventsOfAnExperiment, StandOnTheRecordingsOwnClock) {
  Scenario scenario = late_scenario();
  const Experiment plain = make_experiment(scenario);
  Segment expected = plain.segments[0];
  for (const Event& event : one_of_each_kind(expected)) add_event(expected, event);
  const std::vector<double>& time = scenario.recordings[0].data->columns.front();
  scenario.events = {event_spec(EventSpec::Kind::effort, "slide", kLate + 0.513, kLate + 0.987, 3.0, 0.1),
                     event_spec(EventSpec::Kind::command, "slide", time[120], time[150], 0.0),
                     event_spec(EventSpec::Kind::reading, "slide", time[33], time[77], 0.02)};
  expect_same_happening(make_experiment(scenario).segments[0], expected);
}

TEST(EventsOfAnExperiment, AreTheSameOnceTheyWereSaidAsAScenarioDoes) {
  Scenario scenario = late_scenario();
  const Experiment plain = make_experiment(scenario);
  Segment expected = plain.segments[0];
  for (const Event& event : one_of_each_kind(expected)) {
    add_event(expected, event);
    scenario.events.push_back(spec_of(event, plain.segments[0], plain));
  }
  EXPECT_EQ(scenario.events[0].joint, "slide");
  EXPECT_EQ(scenario.events[0].file, "run.csv");
  EXPECT_NEAR(scenario.events[0].from, kLate + 0.513, kEventRoundings);
  EXPECT_EQ(scenario.events[0].rise, 0.1);
  expect_same_happening(make_experiment(scenario).segments[0], expected);
}

TEST(EventsOfAnExperiment, StandInTheirRecordingAndInNoOther) {
  Scenario scenario = late_scenario();
  add_recording(scenario, recording_of(*scenario.robot, SprungBlock().drive, SprungBlock().start, "second.csv"));
  scenario.events = {event_spec(EventSpec::Kind::effort, "slide", 0.5, 1.0, 3.0)};
  scenario.events[0].file = "second.csv";
  const Experiment experiment = make_experiment(scenario);
  EXPECT_EQ(experiment.segments[0].pushes, nullptr);
  EXPECT_NE(experiment.segments[1].pushes, nullptr);
}

/// What is said of one event of a recording of 2 s.
std::string event_refusal(const EventSpec& event, const std::function<void(Scenario&)>& change = {}) {
  Scenario scenario = DrivenRods().scenario;
  if (change) change(scenario);
  scenario.events = {event};
  return input_error([&] { make_experiment(scenario); });
}

TEST(EventsOfAnExperiment, AreRefusedOutsideOfWhatIsUsedOfTheirRecording) {
  using Kind = EventSpec::Kind;
  EXPECT_EQ(event_refusal(event_spec(Kind::effort, "elbow", 1.5, 2.5, 1.0)), "") << "its begin is in it";
  for (const Kind kind : {Kind::effort, Kind::command, Kind::reading}) {
    EXPECT_EQ(
        event_refusal(event_spec(kind, "elbow", 5.25, 6.5, 1.0)),
        "test: events: found from 5.25 to 6.5 s of \"run.csv\", expected a time within what is used of that recording");
    EXPECT_NE(event_refusal(event_spec(kind, "elbow", -2.0, -1.0, 1.0)), "");
    const auto cut = [](Scenario& s) { s.recordings[0].to = 1.0; };
    EXPECT_NE(event_refusal(event_spec(kind, "elbow", 1.2, 1.4, 1.0), cut), "");
    EXPECT_EQ(event_refusal(event_spec(kind, "elbow", 0.2, 0.4, 1.0), cut), "");
  }
}

TEST(EventsOfAnExperiment, AreRefusedAtAJointThatTheyCannotActOn) {
  using Kind = EventSpec::Kind;
  const EventSpec command = event_spec(Kind::command, "elbow", 0.5, 1.0, 0.0);
  const EventSpec reading = event_spec(Kind::reading, "elbow", 0.5, 1.0, 0.1);
  const auto without = [](ChannelKind kind) { return [kind](Scenario& s) { s.channels.of[kind].erase("elbow"); }; };
  EXPECT_EQ(event_refusal(command, without(ChannelKind::command)),
            "test: events: found no command of \"elbow\", expected a joint with a command channel");
  EXPECT_EQ(event_refusal(reading, without(ChannelKind::position)),
            "test: events: found no position of \"elbow\", expected a joint with a position channel");
  EXPECT_EQ(event_refusal(command, without(ChannelKind::position)), "");
  EXPECT_EQ(event_refusal(reading, without(ChannelKind::command)), "");
}

TEST(EventsOfAnExperiment, AreRefusedWhereTheMotionIsMeasured) {
  Scenario scenario = DrivenRods().scenario;
  Experiment experiment = make_experiment(scenario);
  scenario.prediction = InverseDynamics{4.0};
  scenario.events = {event_spec(EventSpec::Kind::effort, "elbow", 0.5, 1.0, 1.0)};
  EXPECT_EQ(input_error([&] { add_events(scenario, experiment); }),
            "test: events: found an event with inverse_dynamics, expected a simulated motion (free_run or horizon)");
}

}  // namespace
}  // namespace lacuna
