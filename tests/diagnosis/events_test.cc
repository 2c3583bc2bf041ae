// From end to end: what happened in a recording is found, told apart, and kept out of the machine's numbers.
#include "diagnosis/events.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "physics/units.h"
#include "tests/diagnosis/outside.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kEdge = 0.1;           // s, to which begin and end are asked for
constexpr double kPushed = 1.5;         // N m, beside 9 N m of the drive and 4.9 N m of the rod's weight
constexpr double kPushTakes = 0.4;      // s, of OutsidePhysics::Kind::external_push
constexpr double kSlipped = 0.02;       // rad
constexpr double kSamplePeriod = 0.02;  // s, of rested_drive

OutsidePhysics push_at(double from, double strength, int joint = 0) {
  return {OutsidePhysics::Kind::external_push, joint, strength, {{from}}};
}
OutsidePhysics lost_command_at(double from, double seconds, int joint = 0) {
  return {OutsidePhysics::Kind::command_dropout, joint, seconds, {{from}}};
}
std::vector<OutsidePhysics> nothing_in(Role) { return {}; }

/// Positions of a recording read too much in [from, to).
void slip_in(Scenario& scenario, std::size_t recording, double from, double to) {
  auto data = std::make_shared<Recording>(*scenario.recordings[recording].data);
  const std::vector<double>& time = data->columns.front();
  std::vector<double>& q = data->columns[data->find("q_swing")];
  for (std::size_t k = 0; k < time.size(); ++k)
    if (time[k] > from - 0.5 * kSamplePeriod && time[k] < to - 0.5 * kSamplePeriod) q[k] += kSlipped;
  scenario.recordings[recording].data = data;
}

/// Something of every kind: what kHappened lists.
Scenario eventful_pendulum() {
  Scenario out = guessed_pendulum([](Role role) -> std::vector<OutsidePhysics> {
    switch (role) {
      case Role::train: return {push_at(5.0, kPushed), lost_command_at(9.0, 0.4)};
      case Role::validate: return {push_at(14.0, -1.0)};
      default: return {push_at(9.0, kPushed)};
    }
  });
  slip_in(out, 1, 7.0, 8.5);
  return out;
}

struct Happened {
  EventSpec::Kind kind;
  std::string place, recording;
  Role role;
  double from, to;
  std::string resembles;
};
/// In the order of the recordings and of time.
const std::vector<Happened> kHappened{
    {EventSpec::Kind::effort, "swing", "train.csv", Role::train, 5.0, 5.4, "a push"},
    {EventSpec::Kind::command, "swing", "train.csv", Role::train, 9.0, 9.4, "a lost command"},
    {EventSpec::Kind::reading, "swing", "validate.csv", Role::validate, 7.0, 8.5, "a slip of the transducer"},
    {EventSpec::Kind::effort, "swing", "validate.csv", Role::validate, 14.0, 14.4, "a push"},
    {EventSpec::Kind::effort, "swing", "test.csv", Role::test, 9.0, 9.4, "a push"}};

std::string words_of(const std::vector<LearnedEvent>& events) {
  std::string out;
  for (const LearnedEvent& e : events)
    out += fmt::format("{} of {:.3g} at {} in {} from {:.3f} to {:.3f} s; ", e.resembles, e.value, e.place, e.recording,
                       e.from, e.to);
  return out.empty() ? "none" : out;
}

void expect_found(const std::vector<LearnedEvent>& found, const std::vector<Happened>& happened) {
  ASSERT_EQ(found.size(), happened.size()) << words_of(found);
  for (std::size_t k = 0; k < found.size(); ++k) {
    SCOPED_TRACE(words_of({found[k]}));
    EXPECT_EQ(found[k].kind, happened[k].kind);
    EXPECT_EQ(found[k].place, happened[k].place);
    EXPECT_EQ(found[k].recording, happened[k].recording);
    EXPECT_EQ(found[k].role, happened[k].role);
    EXPECT_EQ(found[k].resembles, happened[k].resembles);
    EXPECT_NEAR(found[k].from, happened[k].from, kEdge);
    EXPECT_NEAR(found[k].to, happened[k].to, kEdge);
    EXPECT_GT(found[k].evidence, 0.0);
    EXPECT_FALSE(found[k].pieces.empty());
  }
}

/// Made once for all tests of it.
const Diagnosis& eventful_diagnosis() {
  static const Diagnosis d = diagnosed(eventful_pendulum());
  return d;
}

TEST(Events, AreFoundWhereTheyHappenedAndToldApart) { expect_found(eventful_diagnosis().events, kHappened); }

/// Of an effort over time, N m s; of a slip over time, rad s.
double integral_of(const LearnedEvent& event) {
  double out = 0.0;
  for (const EventSpec& piece : event.pieces) out += piece.value * (piece.to - piece.from - piece.rise);
  return out;
}

TEST(Events, AreAsLargeAsTheMotionShows) {
  const std::vector<LearnedEvent>& found = eventful_diagnosis().events;
  ASSERT_EQ(found.size(), kHappened.size()) << words_of(found);
  // A push is told by the speed that it gives: by its impulse, of a half sine 2 / pi of height times length.
  const double unit_impulse = kPushTakes * 2.0 / std::numbers::pi;
  EXPECT_NEAR(integral_of(found[0]), kPushed * unit_impulse, 0.05 * kPushed * unit_impulse);
  EXPECT_NEAR(integral_of(found[3]), -unit_impulse, 0.05 * unit_impulse);
  EXPECT_NEAR(integral_of(found[4]), kPushed * unit_impulse, 0.05 * kPushed * unit_impulse);
  // A slip by its 75 samples, of which an edge may miss one; their noise is a hundredth of it.
  EXPECT_NEAR(integral_of(found[2]), kSlipped * 1.5, 0.05 * kSlipped * 1.5);
  EXPECT_EQ(found[1].value, 0.0) << "nothing arrived";
  EXPECT_EQ(found[0].unit, "N m");
  EXPECT_EQ(found[1].unit, command_unit(eventful_pendulum(), "swing"));
  EXPECT_EQ(found[2].unit, "rad");
}

TEST(Events, LeaveTheNoiseOfTheRecordingsThatTheyHappenedIn) {
  const Diagnosis& d = eventful_diagnosis();
  for (const Role role : {Role::train, Role::validate}) {
    EXPECT_GT(rms_in_role(d.before, role), 3.0 * kTransducerNoise) << to_string(role);
    // Of a thousand samples the noise's own rms is good to 2 %; a half sine is no trapezoid to the last.
    EXPECT_LT(rms_in_role(d.after, role), 1.15 * kTransducerNoise) << to_string(role);
  }
}

double estimate_named(const FitResult& fit, const std::string& name) {
  const auto found = std::ranges::find(fit.estimates, name, &Estimate::name);
  return found == fit.estimates.end() ? kMissing : found->value;
}

TEST(Events, LeaveTheMachinesNumbersAsTheyAre) {
  const Diagnosis& d = eventful_diagnosis();
  const PendulumTruth truth;
  for (const auto& [name, value] : {std::pair("swing.gain", truth.gain), std::pair("swing.damping", truth.damping),
                                    std::pair("swing.stiffness", truth.stiffness)}) {
    const double before = std::fabs(estimate_named(d.before, name) - value);
    const double after = std::fabs(estimate_named(d.after, name) - value);
    EXPECT_LT(after, before) << name;
    EXPECT_LT(after, 0.01 * value) << name;
  }
}

TEST(Events, AreNoPhysicsThatTheCatalogueNames) {
  const Diagnosis& d = eventful_diagnosis();
  EXPECT_EQ(d.verdict, Verdict::unknown_physics);
  EXPECT_TRUE(d.findings.empty()) << d.findings.front().effect;
  EXPECT_TRUE(d.learned.empty()) << d.learned.front().description;
  EXPECT_TRUE(d.added.empty());
}

TEST(Events, OfTestRecordingsAreSaidAndGoIntoNothingElse) {
  const Diagnosis& d = eventful_diagnosis();
  // The push moves the rod a hundred times as far as noise does, for one of twenty seconds.
  EXPECT_GT(rms_in_role(d.after, Role::test), 5.0 * kTransducerNoise);
  std::vector<std::string> files;
  for (const EventSpec& event : diagnosed_scenario(eventful_pendulum(), d).events) files.push_back(event.file);
  EXPECT_GE(files.size(), 4u);
  EXPECT_EQ(std::ranges::count(files, std::string("test.csv")), 0);

  const Scenario scenario = guessed_pendulum([](Role role) {
    return role == Role::test ? std::vector<OutsidePhysics>{push_at(9.0, kPushed)} : std::vector<OutsidePhysics>{};
  });
  const Diagnosis alone = diagnosed(scenario);
  expect_found(alone.events, {kHappened.back()});
  EXPECT_FALSE(changes_the_model(alone));
  EXPECT_EQ(alone.verdict, Verdict::consistent);
  EXPECT_TRUE(same_bits(alone.after.values, alone.before.values));
  EXPECT_TRUE(diagnosed_scenario(scenario, alone).events.empty());
}

TEST(Events, ExplainTheRecordingsOnceTheyAreInTheScenario) {
  const Scenario again = saved_and_read(diagnosed_scenario(eventful_pendulum(), eventful_diagnosis()));
  EXPECT_GE(again.events.size(), 4u);
  const Diagnosis d = diagnosed(again);
  for (const Role role : {Role::train, Role::validate})
    EXPECT_LT(rms_in_role(d.before, role), 1.15 * kTransducerNoise) << to_string(role);
  EXPECT_EQ(d.verdict, Verdict::consistent);
  expect_found(d.events, {kHappened.back()});
}

TEST(Events, HaveTheSameBitsOnOneThreadAndOnTwo) {
  const auto numbers = [](const Diagnosis& d) {
    std::vector<double> out = d.after.values;
    for (const LearnedEvent& e : d.events) {
      out.insert(out.end(), {e.from, e.to, e.value, e.evidence});
      for (const EventSpec& piece : e.pieces) out.insert(out.end(), {piece.from, piece.to, piece.value, piece.rise});
    }
    return out;
  };
  const Diagnosis one = diagnosed(eventful_pendulum(), 1);
  EXPECT_EQ(one.events.size(), kHappened.size());
  EXPECT_TRUE(same_bits(numbers(one), numbers(eventful_diagnosis())));
}

TEST(Events, AreNoneWhereTheModelIsExact) {
  for (const std::uint64_t seed : {11, 111, 211, 311}) {
    const Diagnosis d = diagnosed(guessed_pendulum(nothing_in, kEveryRole, seed));
    EXPECT_TRUE(d.events.empty()) << "seed " << seed << ": " << words_of(d.events);
    EXPECT_FALSE(changes_the_model(d));
  }
}

TEST(Events, AreNoneWhereALawActsAllTheTime) {
  const OutsidePhysics ripple{OutsidePhysics::Kind::position_ripple, 0, 0.2, {}};
  const Diagnosis d = diagnosed(guessed_pendulum([&](Role) { return std::vector<OutsidePhysics>{ripple}; }));
  EXPECT_EQ(d.learned.size(), 1u);
  EXPECT_TRUE(d.events.empty()) << words_of(d.events);
}

TEST(Events, MayBeASlipThatStaysToTheLastSample) {
  Scenario scenario = guessed_pendulum(nothing_in);
  slip_in(scenario, 0, 12.0, HUGE_VAL);
  const Diagnosis d = diagnosed(scenario);
  expect_found(d.events, {{EventSpec::Kind::reading, "swing", "train.csv", Role::train, 12.0, kRecordedFor,
                           "a slip of the transducer"}});
  EXPECT_LT(rms_in_role(d.after, Role::train), 1.15 * kTransducerNoise);
}

TEST(Events, MayBeACommandThatStayed) {
  constexpr std::ptrdiff_t kFirst = 150, kEnd = 170;  // samples: 3.0 to 3.4 s
  Scenario scenario = guessed_pendulum(nothing_in);
  const Drive told = rested_drive(kRecordedFor, 0.0);
  const double stayed = told.u[0][kFirst - 1];
  Drive arrived = told;
  std::fill(arrived.u[0].begin() + kFirst, arrived.u[0].begin() + kEnd, stayed);
  const auto data = recording_with({}, pendulum_scenario({}), arrived, "train.csv", 11);
  data->columns[data->find("u_swing")] = told.u[0];
  scenario.recordings[0].data = data;
  const Diagnosis d = diagnosed(scenario);
  expect_found(d.events,
               {{EventSpec::Kind::command, "swing", "train.csv", Role::train, 3.0, 3.4, "a repeated command"}});
  ASSERT_FALSE(d.events.empty());
  EXPECT_EQ(d.events.front().value, stayed);
}

TEST(Events, AreFoundAtTheirOwnJoint) {
  const auto rods = [](const PendulumTruth& p) {
    const std::map<std::string, double> drive{{"gain", p.gain}, {"damping", p.damping}, {"stiffness", p.stiffness}};
    return bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                         {actuator("shoulder", "torque_source", drive), actuator("elbow", "torque_source", drive)},
                         false);
  };
  Scenario scenario = rods(kGuessed);
  add_recording(scenario, recording_with({push_at(6.0, 1.0, 1), lost_command_at(12.3, 0.4, 1)}, rods({}),
                                         rested_drive(kRecordedFor, 0.0, 2), "train.csv", 3));
  add_recording(
      scenario,
      recording_with({push_at(9.0, -1.5, 0)}, rods({}), rested_drive(kRecordedFor, 7.3, 2), "validate.csv", 4),
      Role::validate);
  search_plain_numbers(scenario);
  expect_found(diagnosed(scenario).events,
               {{EventSpec::Kind::effort, "elbow", "train.csv", Role::train, 6.0, 6.4, "a push"},
                {EventSpec::Kind::command, "elbow", "train.csv", Role::train, 12.3, 12.7, "a lost command"},
                {EventSpec::Kind::effort, "shoulder", "validate.csv", Role::validate, 9.0, 9.4, "a push"}});
}

}  // namespace
}  // namespace lacuna
