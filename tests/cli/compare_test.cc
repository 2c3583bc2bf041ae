#include <algorithm>
#include <cmath>

#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

namespace fs = std::filesystem;

const char* const kUrdf =
    "<robot name='two'><link name='base'/>"
    "<link name='a'><inertial><origin xyz='0 0 -0.4'/><mass value='2'/><inertia ixx='0.1' iyy='0.1' izz='0.02' ixy='0' "
    "ixz='0' iyz='0'/></inertial></link>"
    "<link name='b'><inertial><origin xyz='0 0 -0.2'/><mass value='1'/><inertia ixx='0.02' iyy='0.02' izz='0.01' "
    "ixy='0' ixz='0' iyz='0'/></inertial></link>"
    "<joint name='one' type='continuous'><parent link='base'/><child link='a'/><axis xyz='0 1 0'/></joint>"
    "<joint name='two' type='continuous'><parent link='a'/><child link='b'/><origin xyz='0 0 -0.8'/><axis xyz='0 1 "
    "0'/></joint></robot>";

std::string scenario_text(const std::string& name, const std::string& motion) {
  return "format: lacuna-scenario/1\nname: " + name + "\nrobot: two.urdf\n" + motion;
}

/// A folder with one short scenario.
struct Pair {
  TemporaryFolder files;
  std::string scenario;
  explicit Pair(const std::string& motion = "motion: {duration: 0.1, position: {one: 1.0}}\n") {
    files.write("two.urdf", kUrdf);
    scenario = files.write("scenario.yaml", scenario_text("pair", motion)).string();
  }
  std::string out() const { return (files.path() / "out").string(); }
};

const std::vector<std::string> kFast{"--no-pictures", "--no-identify", "--threads", "2"};

std::vector<std::string> line(std::vector<std::string> start, const std::vector<std::string>& more = {}) {
  start.insert(start.end(), kFast.begin(), kFast.end());
  start.insert(start.end(), more.begin(), more.end());
  return start;
}

/// What the file's contract asks of every engine.
void expect_record(const nlohmann::json& engine) {
  for (const char* key :
       {"max_acceleration_difference", "trajectory_error", "energy_drift", "ns_per_step", "realtime_factor"}) {
    ASSERT_TRUE(engine.at(key).is_number()) << engine.at("engine") << ", " << key;
    EXPECT_GE(engine.at(key).get<double>(), 0.0) << key;
  }
  EXPECT_LT(engine.at("max_acceleration_difference").get<double>(), 1e-9);
  EXPECT_LT(engine.at("trajectory_error").get<double>(), 1e-6);
  EXPECT_GT(engine.at("ns_per_step").get<double>(), 0.0);
  ASSERT_FALSE(engine.at("work_precision").empty());
  EXPECT_GE(engine.at("work_precision")[0].at("points").size(), 5u);
}

TEST(Compare, EveryEngineBuiltIsMeasured) {
  const Pair pair;
  const auto record = json_of(lacuna(line({"compare", pair.scenario, "-o", pair.out(), "--json"})));
  EXPECT_EQ(record.at("format"), "lacuna-compare/1");
  EXPECT_EQ(record.at("scenario"), "pair");
  EXPECT_TRUE(record.at("context").contains("command_line"));
  std::vector<std::string> named, built;
  for (const auto& engine : record.at("engines")) {
    named.push_back(engine.at("engine"));
    expect_record(engine);
  }
  for (const auto& engine : engine_records())
    if (engine.at("available").get<bool>()) built.push_back(engine.at("name"));
  EXPECT_EQ(named, built);
  const auto& scenario = record.at("scenarios")[0];
  EXPECT_LT(scenario.at("referee").at("error").get<double>(), 1e-12);
  for (const auto& engine : scenario.at("engines")) EXPECT_GE(engine.at("acceleration_states").get<int>(), 1000);
  EXPECT_EQ(json_file(fs::path(pair.out()) / "compare.json"), record);
  EXPECT_TRUE(fs::exists(fs::path(pair.out()) / "report.html"));
}

TEST(Compare, AListOfEnginesAndAFolderOfScenarios) {
  const Pair pair;
  pair.files.write("set/first/two.urdf", kUrdf);
  pair.files.write("set/first/scenario.yaml",
                   scenario_text("first", "motion: {duration: 0.1, position: {one: 0.5}}\n"));
  pair.files.write("set/second/two.urdf", kUrdf);
  pair.files.write("set/second/scenario.yaml",
                   scenario_text("second", "motion: {duration: 0.1, velocity: {two: 1}}\n"));
  const std::string set = (pair.files.path() / "set").string();
  const auto record = json_of(lacuna(line({"compare", set, "--engine", "featherstone", "-o", pair.out(), "--json"})));
  EXPECT_EQ(record.at("scenario"), (nlohmann::json{"first", "second"}));
  ASSERT_EQ(record.at("engines").size(), 1u);
  expect_record(record.at("engines")[0]);
  EXPECT_EQ(record.at("scenarios").size(), 2u);
}

TEST(Compare, AgainstItselfNoErrorHasChanged) {
  const Pair pair;
  const std::vector<std::string> first{"compare", pair.scenario, "--engine", "featherstone", "-o", pair.out()};
  ASSERT_EQ(lacuna(line(first)).code, 0);
  const std::string old = (fs::path(pair.out()) / "compare.json").string();
  const Outcome again = lacuna(line({"compare", pair.scenario, "--engine", "featherstone", "-o",
                                     (pair.files.path() / "again").string(), "--baseline", old, "--json"}));
  const auto baseline = json_of(again).at("baseline");
  EXPECT_GT(baseline.at("figures_compared").get<int>(), 5);
  for (const auto& change : baseline.at("changes")) {  // timings may differ on a busy machine; errors may not
    const std::string quantity = change.at("quantity");
    EXPECT_TRUE(quantity.find("_ns") != std::string::npos || quantity.find("_us") != std::string::npos ||
                quantity.find("ns_per_step") != std::string::npos)
        << quantity;
  }
  expect_refused(lacuna(line({"compare", pair.scenario, "-o", pair.out(), "--baseline", old})), 2, "--output");
}

TEST(Compare, BadInputIsRefused) {
  const Pair pair;
  const auto refused = [&](const std::string& motion, const std::string& part) {
    const std::string file = pair.files.write("bad.yaml", scenario_text("bad", motion)).string();
    expect_refused(lacuna(line({"compare", file, "-o", pair.out()})), 2, part);
  };
  refused("motion: {duration: 0}\n", "duration");
  refused("motion: {position: {three: 1}}\n", "three");
  refused("motion: {speed: 1}\n", "speed");
  refused("motion: {commands: none.csv}\n", "channels");
  refused("motion: {pickup: {mass: 3}}\n", "time");
  refused("motion: {duration: 0.1, pickup: {mass: 3, time: 7}}\n", "pickup");
  refused("channels: {time: t, command: {one: u}}\nmotion: {commands: ../../../etc/passwd}\n", "folder");
  expect_refused(lacuna(line({"compare", pair.scenario, "--engine", "imaginary"})), 2, "imaginary");
  expect_refused(lacuna(line({"compare", pair.scenario, "--duration", "-1"})), 2, "--duration");
  expect_refused(lacuna(line({"compare", (pair.files.path() / "none").string()})), 2, "none");
  expect_refused(lacuna(line({"compare", pair.scenario, "--baseline", pair.scenario, "-o", pair.out()})), 2,
                 "lacuna-compare/1");
}

TEST(Compare, IdentifiesOnEveryPair) {
  const Pair pair;
  std::string commands = "t,u\n";
  for (int i = 0; i < 60; ++i) commands += std::to_string(0.01 * i) + (i % 20 < 10 ? ",3\n" : ",-2\n");
  pair.files.write("commands.csv", commands);
  const std::string file =
      pair.files
          .write("driven.yaml", scenario_text("driven",
                                              "actuators:\n  two: {model: torque_source, gain: 2, damping: 0.3, "
                                              "stiffness: 4, rest: 0}\n"
                                              "identify: {gain: {relative_bounds: [0.5, 2]}}\n"
                                              "channels: {time: t, command: {two: u}}\n"
                                              "motion: {commands: commands.csv}\n"))
          .string();
  const auto record = json_of(lacuna(
      {"compare", file, "--engine", "featherstone", "--no-pictures", "-o", pair.out(), "--json", "--threads", "2"}));
  const auto& fits = record.at("scenarios")[0].at("identification");
  ASSERT_EQ(fits.at("pairs").size(), 1u);
  // Data of RK4 with efforts held over 0.6 ms, found by RK4 with efforts followed: what differs is half a step of lag.
  EXPECT_LT(fits.at("pairs")[0].at("parameter_error").get<double>(), 0.02);
  EXPECT_GT(fits.at("pairs")[0].at("evaluations").get<int>(), 10);
}

TEST(Simulators, AnEnginesOwnStepsAndFrictionAreToldApartOnAnother) {
  const auto engines = engine_records();
  const auto able = std::ranges::find_if(
      engines, [](const auto& e) { return e.at("name") == "mujoco" && e.at("available").template get<bool>(); });
  const Arm arm({"elbow.gain=20"});
  if (able == engines.end()) {
    expect_refused(lacuna({"compare", arm.scenario(), "--simulators", "featherstone,featherstone"}), kBadInput,
                   "twice");
    return;
  }
  const fs::path out = arm.folder() / "out";
  const auto record = json_of(lacuna({"compare", arm.scenario(), "--simulators", "mujoco,featherstone", "--step",
                                      "0.004", "-o", out.string(), "--json", "--threads", "2"}));
  EXPECT_EQ(record, json_file(out / "simulators.json"));
  EXPECT_EQ(record.at("format"), "lacuna-simulators/1");
  EXPECT_EQ(record.at("recorded_by").at("integrator"), "euler");
  // MuJoCo's Euler steps under efforts held over them are of first order.
  EXPECT_NEAR(record.at("order").get<double>(), 1.0, 0.2);
  const double friction = record.at("joints")[0].at("own_friction");
  EXPECT_GT(friction, 0.0);
  for (const auto& diagnosis : record.at("diagnoses")) {
    const auto& found = diagnosis.at("findings");
    EXPECT_TRUE(std::ranges::any_of(
        found,
        [](const auto& f) { return f.at("effect").template get<std::string>().find("friction") != std::string::npos; }))
        << "its own dry friction is physics that the plain model lacks, at any step: " << found;
    EXPECT_TRUE(fs::exists(out / diagnosis.at("folder").get<std::string>() / "diagnosis.json"));
  }
  EXPECT_FALSE(record.at("numbers").empty());
  EXPECT_NE(text_of(out / "report.html").find("What remains"), std::string::npos);
  // The case that was diagnosed runs again as it is.
  EXPECT_EQ(
      lacuna({"simulate", (out / "step" / "scenario.yaml").string(), "-o", (arm.folder() / "again").string()}).code, 0);
}

TEST(Simulators, WhatCannotBeDoneIsRefusedInOneLine) {
  const Arm arm;
  const auto refused = [&](const std::vector<std::string>& more, int code, const std::string& part) {
    std::vector<std::string> words{"compare", arm.scenario(), "-o", (arm.folder() / "out").string()};
    words.insert(words.end(), more.begin(), more.end());
    expect_refused(lacuna(words), code, part);
  };
  refused({"--simulators", "featherstone"}, kBadInput, "two engines");
  refused({"--simulators", "imaginary,featherstone"}, kBadInput, "imaginary");
  for (const auto& engine : engine_records())
    if (engine.at("available").get<bool>() && engine.at("name") != "featherstone") {
      refused({"--simulators", "featherstone," + engine.at("name").get<std::string>()}, kNotDone, "of its own");
      break;
    }
  for (const auto& engine : engine_records())
    if (engine.at("name") == "mujoco" && engine.at("available").get<bool>()) {
      refused({"--simulators", "mujoco,featherstone", "--integrator", "magic"}, kBadInput, "implicit");
      refused({"--simulators", "mujoco,featherstone", "--own-friction", "-1"}, kBadInput, "--own-friction");
      refused({"--simulators", "mujoco,featherstone", "--step", "0"}, kBadInput, "--step");
    }
}

}  // namespace
}  // namespace lacuna::test
