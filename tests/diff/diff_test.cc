// Two sets of recordings of a double pendulum, made by another engine and integrator than those that compare them.
#include "diff/diff.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "reports/diff.h"
#include "tests/diagnosis/outside.h"
#include "tests/physics/efforts.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kSeconds = 10.0;

/// The machine whose recordings are compared.
Scenario double_pendulum(double elbow_gain = 2.0) {
  return bare_scenario(
      bundled_robot("double_pendulum/double_pendulum.urdf"),
      {actuator("shoulder", "torque_source", {{"gain", 6.0}, {"damping", 2.0}, {"stiffness", 8.0}, {"rest", 0.0}}),
       actuator("elbow", "torque_source", {{"gain", elbow_gain}, {"damping", 0.5}, {"stiffness", 3.0}, {"rest", 0.0}})},
      false);
}

/// One set: what `truth` did from rest, and the plain model with start values that are off.
Scenario set_of(const Scenario& truth, const std::string& name, std::uint64_t seed, bool masses = false) {
  Scenario out = double_pendulum();
  out.name = name;
  for (ActuatorSpec& a : out.actuators) a.parameters["gain"] *= 1.2, a.parameters["damping"] *= 0.8;
  for (const Role role : kEveryRole) {
    const auto k = static_cast<std::uint64_t>(role);
    const Drive drive = rested_drive(kSeconds, 7.3 * static_cast<double>(k) + 0.37 * static_cast<double>(seed), 2);
    add_recording(out, recording_with({}, truth, drive, std::string(to_string(role)) + ".csv", 10 * seed + k), role);
  }
  search_plain_numbers(out);
  if (masses) out.identify.push_back({"mass", true, 0.4, 2.5, "test: identify.mass"});
  return out;
}

Diff compared(const Scenario& a, const Scenario& b) {
  // What was before is the same in most tests, and diagnosed once.
  static std::map<std::string, Diagnosis> known;
  const auto found = [&](const Scenario& s) -> const Diagnosis& {
    if (!known.contains(s.name)) known.emplace(s.name, diagnosed(s));
    return known.at(s.name);
  };
  check_comparable(a, b);
  IdentifyOptions options;
  options.simulator.threads = 2;
  return compare_sets(a, found(a), b, found(b), options);
}

double rms_of(const JointRms& rms, const std::string& joint) {
  for (const auto& [name, value] : rms)
    if (name == joint) return value;
  return kMissing;
}

void expect_covers(const Estimate& e, double value) {
  EXPECT_LE(e.lower95, value) << e.name;
  EXPECT_GE(e.upper95, value) << e.name;
}

TEST(Diff, SaysNothingWhereNothingChanged) {
  const Diff d = compared(set_of(double_pendulum(), "before", 1), set_of(double_pendulum(), "again", 2));
  EXPECT_EQ(d.verdict, DiffVerdict::same);
  EXPECT_TRUE(d.changes.empty());
  EXPECT_GT(d.no_change, 0.9);
  EXPECT_EQ(d.shared.size(), 6u);
  for (const SharedNumber& s : d.shared) EXPECT_LT(s.changed, 0.1) << s.pooled.name;
}

TEST(Diff, FindsAGainThatChangedAndPoolsTheRest) {
  const Diff d = compared(set_of(double_pendulum(), "before", 1), set_of(double_pendulum(2.1), "gain", 3));
  EXPECT_EQ(d.verdict, DiffVerdict::changed);
  ASSERT_EQ(d.changes.size(), 1u);
  const MachineChange& c = d.changes.front();
  EXPECT_EQ(c.name, "elbow.gain");
  EXPECT_GT(c.probability, 0.95);
  EXPECT_GT(c.heldout_gain, 2.0 * c.heldout_error);
  expect_covers(c.numbers.front().a, 2.0);
  expect_covers(c.numbers.front().b, 2.1);
  expect_covers(c.numbers.front().difference, 0.1);
  for (const SharedNumber& s : d.shared)
    if (s.pooled.name == "shoulder.gain") expect_covers(s.pooled, 6.0);
  // On recordings that took no part, the common model with the change is as good as B's own, and A's is not.
  const DiffFit& test = d.b.fit.back();
  ASSERT_EQ(test.role, Role::test);
  EXPECT_LT(rms_of(test.joint, "elbow"), 1.1 * kTransducerNoise);
  EXPECT_GT(rms_of(test.of_a, "elbow"), 3.0 * kTransducerNoise);
}

TEST(Diff, FindsFrictionThatGrewAtItsJoint) {
  Scenario worn = double_pendulum(), new_one = worn;
  new_one.effects = {effect("coulomb_friction", "elbow", {{"Fc", 0.2}})};
  worn.effects = {effect("coulomb_friction", "elbow", {{"Fc", 0.3}})};
  const Diff d = compared(set_of(new_one, "run in", 4), set_of(worn, "worn", 5));
  ASSERT_EQ(d.changes.size(), 1u);
  EXPECT_EQ(d.changes[0].effect, "coulomb_friction");
  EXPECT_EQ(d.changes[0].place, "elbow");
  EXPECT_GT(d.changes[0].class_probability, 0.9);
  expect_covers(d.changes[0].numbers.front().difference, 0.1);
}

TEST(Diff, FindsFrictionThatOneSetAloneHas) {
  Scenario worn = double_pendulum();
  worn.effects = {effect("coulomb_friction", "shoulder", {{"Fc", 0.4}})};
  const Diff d = compared(set_of(worn, "rubbing", 6), set_of(double_pendulum(), "before", 1));
  ASSERT_EQ(d.changes.size(), 1u);
  EXPECT_EQ(d.changes[0].effect, "coulomb_friction");
  EXPECT_EQ(d.changes[0].place, "shoulder");
  // Gone after the repair.
  EXPECT_NEAR(d.changes[0].numbers.front().difference.value, -0.4, 0.02);
  EXPECT_LT(d.changes[0].numbers.front().b.value, 0.02);
}

TEST(Diff, FindsALoadThatFreeMassesHideFromEachDiagnosis) {
  Scenario loaded = double_pendulum();
  loaded.effects = {effect("payload", "arm", {{"m", 0.2}})};
  const Diff d = compared(set_of(double_pendulum(), "empty", 7, true), set_of(loaded, "loaded", 8, true));
  EXPECT_EQ(d.verdict, DiffVerdict::changed);
  ASSERT_EQ(d.changes.size(), 1u);
  const MachineChange& c = d.changes.front();
  const bool load =
      c.name == "arm.payload" || std::find(c.members.begin(), c.members.end(), "arm.payload") != c.members.end();
  EXPECT_TRUE(load) << c.name;
  EXPECT_GT(c.class_probability, 0.9);
}

/// Measured efforts of rods of which the outer one is not as drawn, so that each set's own diagnosis frees its mass.
Scenario pushed_set(const std::string& name, double load, double shift) {
  const std::map<std::string, double> damped{{"gain", 1.0}, {"damping", 1.2}};
  const std::vector<EffectSpec> truth{effect("rigid_body", "elbow", {{"alpha", 0.25}, {"t1", 0.08}}),
                                      effect("payload", "arm", {{"m", load}})};
  Scenario out = pushed_rods({}, "direct_effort", damped);
  out.name = name;
  out.prediction = InverseDynamics{8.0};
  out.identify = {{"damping", true, 0.2, 5.0, "test: identify"}};
  for (const Role role : kEveryRole) {
    std::vector<double> time;
    for (int k = 0; k <= 10000; ++k) time.push_back(0.001 * k);
    const auto k = static_cast<std::uint64_t>(role);
    const Drive drive = sines_at(time, 6.0, 7.3 * static_cast<double>(k) + shift);
    const std::string file = std::string(to_string(role)) + ".csv";
    add_recording(out, truth_recording(pushed_rods(truth, "direct_effort", damped), drive, file, 0.5, 10 + k), role);
  }
  return out;
}

TEST(Diff, CallsALinkThatGainedWeightALoad) {
  constexpr double kLoad = 0.4;  // kg
  const Diff d = compared(pushed_set("unloaded rods", 0.0, 0.0), pushed_set("loaded rods", kLoad, 0.37));
  ASSERT_EQ(d.changes.size(), 1u);
  EXPECT_EQ(d.changes.front().name, "arm.payload");
  EXPECT_GT(d.changes.front().class_probability, 0.9);
  expect_covers(d.changes.front().numbers.front().b, kLoad);
}

TEST(Diff, SaysThatTheSetsDifferWhereNoNumberSaysHow) {
  // A ripple of the transducer that one set alone has: no effect of the catalogue makes it.
  const Scenario before = set_of(double_pendulum(), "before", 1);
  Scenario rippled = set_of(double_pendulum(), "rippled", 9);
  for (RecordingSpec& recording : rippled.recordings) {
    auto data = std::make_shared<Recording>(*recording.data);
    auto& q = data->columns[data->find("q_elbow")];
    for (std::size_t k = 25; k < q.size(); ++k)
      q[k] += 6.0 * kTransducerNoise * std::sin(0.26 * static_cast<double>(k));
    recording.data = data;
  }
  const Diff d = compared(before, rippled);
  EXPECT_EQ(d.verdict, DiffVerdict::unknown_change);
  EXPECT_TRUE(d.changes.empty()) << d.changes.front().name;
  EXPECT_EQ(d.rest_in_b, std::vector<std::string>{"elbow"});
  EXPECT_TRUE(d.rest_in_a.empty());
}

TEST(Diff, SameBitsOnOneThreadAndOnTwo) {
  const Scenario a = set_of(double_pendulum(), "before", 1), b = set_of(double_pendulum(2.1), "gain", 3);
  const Diagnosis da = diagnosed(a), db = diagnosed(b);
  const auto run = [&](int threads) {
    IdentifyOptions options;
    options.simulator.threads = threads;
    Diff d = compare_sets(a, da, b, db, options);
    d.seconds = 0.0;
    return to_json(d, Context{});
  };
  EXPECT_EQ(run(1), run(2));
}

TEST(Diff, RecordHoldsWhatIsPromisedAndPagesEscapeNames) {
  Scenario a = set_of(double_pendulum(), "before", 1);
  Diff d = compared(a, set_of(double_pendulum(2.1), "gain", 3));
  d.b.name = "<script>alert(1)</script>";
  const auto record = nlohmann::json::parse(to_json(d, Context{}));
  EXPECT_EQ(record.at("format"), "lacuna-diff/1");
  EXPECT_EQ(record.at("verdict"), "changed");
  const auto& change = record.at("changes").at(0);
  for (const char* key : {"name", "where", "parameter", "a", "b", "difference", "unit", "probability", "class",
                          "class_probability", "look_alikes", "numbers", "evidence"})
    EXPECT_TRUE(change.contains(key)) << key;
  EXPECT_EQ(change.at("difference").at("ci95").size(), 2u);
  EXPECT_EQ(record.at("shared").size(), 5u);
  EXPECT_TRUE(record.at("b").at("fit").at("test").at("model_a").contains("elbow"));
  EXPECT_TRUE(record.contains("context"));
  const std::string page = diff_page(a, d, Context{});
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;"), std::string::npos);
}

TEST(Comparable, RefusesWhatIsNotOneMachineSeenInOneWay) {
  const Scenario a = set_of(double_pendulum(), "a", 1);
  const auto message = [&](const std::function<void(Scenario&)>& spoil) {
    Scenario b = a;
    b.file = "other/scenario.yaml";
    spoil(b);
    return input_error([&] { check_comparable(a, b); });
  };
  const auto says = [](const std::string& part) {
    return testing::AllOf(testing::HasSubstr("other/scenario.yaml: "), testing::HasSubstr(part),
                          testing::HasSubstr("as in test/scenario.yaml"));
  };
  EXPECT_THAT(message([](Scenario& b) { b.robot = bundled_robot("pendulum/pendulum.urdf"); }), says("robot"));
  EXPECT_THAT(message([](Scenario& b) { b.gravity.z() = -1.62; }), says("gravity: found -1.62, expected -9.81"));
  EXPECT_THAT(message([](Scenario& b) { b.total_mass = 3.0; }), says("total_mass"));
  EXPECT_THAT(message([](Scenario& b) { b.actuators[1].model = "flow_source"; }), says("actuators.elbow.model"));
  EXPECT_THAT(message([](Scenario& b) { b.actuators[0].parameters["gain"] = 7.0; }), says("actuators.shoulder.gain"));
  EXPECT_THAT(message([](Scenario& b) { b.actuators.pop_back(); }), says("actuators.elbow.model: found none"));
  EXPECT_THAT(message([](Scenario& b) { b.identify.pop_back(); }), says("identify: found none"));
  EXPECT_THAT(message([](Scenario& b) { b.channels.of[ChannelKind::position]["elbow"].scale = 2.0; }),
              says("channels.position.elbow"));
  EXPECT_THAT(message([](Scenario& b) { b.channels.of[ChannelKind::command].erase("elbow"); }),
              says("channels.command.elbow: found none"));
  EXPECT_THAT(message([](Scenario& b) {
                b.effects.push_back(effect("payload", "arm", {{"m", 1.0}}));
              }),
              says("effects"));
  EXPECT_THAT(message([](Scenario& b) { b.prediction = Windows{2.0}; }), says("prediction"));
  Scenario renamed = a;
  renamed.name = "unit 2";
  renamed.noise.clear();
  EXPECT_NO_THROW(check_comparable(a, renamed));
}

}  // namespace
}  // namespace lacuna
