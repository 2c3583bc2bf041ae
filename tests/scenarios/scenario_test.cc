#include "scenarios/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "scenarios/files.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::input_error;
using test::kRecording;
using test::kScenario;
using test::replaced;
using test::ScenarioFolder;
using test::Spoiled;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Scenario, LoadsEverySection) {
  const ScenarioFolder folder;
  const Scenario s = load_scenario(folder.file);
  EXPECT_EQ(s.name, "two");
  EXPECT_EQ(s.robot->dof(), 2);
  EXPECT_EQ(s.gravity, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(s.sample_period, 0.1);
  EXPECT_EQ(s.total_mass, 3.0);
  ASSERT_EQ(s.actuators.size(), 2u);
  EXPECT_EQ(s.actuators[0].model, "torque_source");
  EXPECT_EQ(s.actuators[0].parameters.at("gain"), 10.0);
  EXPECT_THAT(s.actuators[0].where, testing::EndsWith("scenario.yaml:8: actuators.a"));
  ASSERT_EQ(s.identify.size(), 2u);
  EXPECT_TRUE(s.identify[0].relative);
  EXPECT_FALSE(s.identify[1].relative);
  EXPECT_EQ(s.identify[1].upper, 4.0);
  EXPECT_EQ(s.channels.time, "t");
  const ColumnSpec& u_b = s.channels.of.at(ChannelKind::command).at("b");
  EXPECT_EQ(u_b.column, "u_b");
  EXPECT_EQ(u_b.scale, 2.0);
  EXPECT_EQ(u_b.offset, -1.0);
  EXPECT_EQ(u_b.unit, "%");
  EXPECT_EQ(s.noise.at(ChannelKind::position).at("b"), 0.002);
  ASSERT_EQ(s.recordings.size(), 2u);
  EXPECT_EQ(s.recordings[1].role, Role::test);
  EXPECT_EQ(s.recordings[1].from, 0.4);
  EXPECT_FALSE(s.recordings[1].to);
  EXPECT_EQ(s.recordings[0].data, s.recordings[1].data) << "one load per file";
  ASSERT_EQ(s.effects.size(), 1u);
  EXPECT_EQ(s.effects[0].parameters.at("Fc"), 3.5);
  EXPECT_EQ(std::get<Windows>(s.prediction).horizon, 0.2);
}

TEST(Scenario, NotesPressuresThatNothingPredicts) {
  const std::string measured = replaced(kScenario, "noise:\n", "  pressure_a: {a: p_a, b: p_b}\nnoise:\n");
  const auto notes_of = [](const std::string& scenario) {
    const ScenarioFolder folder(scenario);
    folder.write("run.csv",
                 "t,u_a,u_b,q_a,q_b,p_a,p_b\n0,1,2,.1,.2,5,6\n.1,1,2,.1,.2,5,6\n.2,1,2,.1,.2,5,6\n"
                 ".3,1,2,.1,.2,5,6\n.4,1,2,.1,.2,5,6\n.5,1,2,.1,.2,5,6\n.6,1,2,.1,.2,5,6\n");
    return load_scenario(folder.file).notes;
  };
  const auto at = [](const char* joint) { return testing::StartsWith("channels.pressure_a of " + std::string(joint)); };
  EXPECT_THAT(notes_of(measured), ElementsAre(at("a"), at("b")));
  const std::string hydraulic = replaced(measured, "a: {model: torque_source, gain: 10, damping: 2}",
                                         "a: {model: hydraulic, gain: 1e-9, area_a: 1e-3, area_b: 1e-3}");
  EXPECT_THAT(notes_of(replaced(hydraulic, "  a.damping: [1, 4]\n", "")), ElementsAre(at("b")));
  const std::string inverse = replaced(hydraulic, "{horizon: 0.2}", "{inverse_dynamics: {cutoff_hz: 2}}");
  EXPECT_THAT(notes_of(inverse), testing::IsSupersetOf({at("a"), at("b")}));
}

/// Pressures measured at both joints, a hydraulic actuator at joint a.
std::string pressed(const std::string& prediction) {
  std::string out = replaced(kScenario, "noise:\n", "  pressure_a: {a: p_a}\n  pressure_b: {a: p_b}\nnoise:\n");
  out = replaced(out, "a: {model: torque_source, gain: 10, damping: 2}",
                 "a: {model: hydraulic, gain: 1e-9, area_a: 1e-3, area_b: 1e-3}");
  return replaced(replaced(out, "  a.damping: [1, 4]\n", ""), "{horizon: 0.2}", prediction);
}
Scenario loaded_pressed(const std::string& scenario) {
  const ScenarioFolder folder(scenario);
  folder.write("run.csv",
               "t,u_a,u_b,q_a,q_b,p_a,p_b\n0,1,2,.1,.2,5,6\n.1,1,2,.1,.2,5,6\n.2,1,2,.1,.2,5,6\n"
               ".3,1,2,.1,.2,5,6\n.4,1,2,.1,.2,5,6\n.5,1,2,.1,.2,5,6\n.6,1,2,.1,.2,5,6\n");
  return load_scenario(folder.file);
}

TEST(Scenario, MayBeDrivenByPressures) {
  const Scenario whole = loaded_pressed(pressed("{pressure_driven: free_run}"));
  EXPECT_TRUE(whole.pressure_driven);
  EXPECT_TRUE(std::holds_alternative<FreeRun>(whole.prediction));
  EXPECT_THAT(whole.notes, ElementsAre(HasSubstr("channels.command of a: not used")));
  const Scenario windows = loaded_pressed(pressed("{pressure_driven: {horizon: 0.3}}"));
  EXPECT_TRUE(windows.pressure_driven);
  EXPECT_EQ(std::get<Windows>(windows.prediction).horizon, 0.3);
  EXPECT_FALSE(loaded_pressed(pressed("{horizon: 0.2}")).pressure_driven);
  for (const std::string given : {"{pressure_driven: free_run}", "{pressure_driven: {horizon: 0.3}}"}) {
    const ScenarioFolder folder(pressed(given));
    ScenarioOptions options;
    options.load_recordings = false;
    save_scenario(load_scenario(folder.file, options), folder.path() / "again.yaml");
    std::ifstream again(folder.path() / "again.yaml");
    const std::string text{std::istreambuf_iterator<char>(again), {}};
    EXPECT_THAT(text, HasSubstr("prediction: " + given));
  }
}

TEST(Scenario, IsDrivenByPressuresOnlyWhereBothAreMeasuredAndActOnAreas) {
  const auto error = [](const std::string& scenario) { return input_error([&] { loaded_pressed(scenario); }); };
  const std::string driven = pressed("{pressure_driven: free_run}");
  EXPECT_THAT(error(replaced(driven, "  pressure_b: {a: p_b}\n", "")),
              HasSubstr("prediction.pressure_driven: found no channels.pressure_b of \"a\", expected both pressures"));
  EXPECT_THAT(error(replaced(driven, "model: hydraulic, gain: 1e-9, area_a: 1e-3, area_b: 1e-3",
                             "model: torque_source, gain: 1")),
              HasSubstr("expected an actuator of the model hydraulic"));
  EXPECT_THAT(error(pressed("{pressure_driven: guess}")),
              HasSubstr("found \"guess\", expected free_run or {horizon: s}"));
  EXPECT_THAT(error(pressed("{pressure_driven: free_run, horizon: 0.2}")), HasSubstr("expected free_run"));
}

TEST(Scenario, NotesMissingMeasuredValues) {
  const ScenarioFolder folder;
  EXPECT_THAT(load_scenario(folder.file).notes, ElementsAre("run.csv: 2 missing values left out (q_a 1, q_b 1)"));
}

TEST(Scenario, NeedsFormatNameAndRobotOnly) {
  const ScenarioFolder folder("format: lacuna-scenario/1\nname: bare\nrobot: two.urdf\n");
  const Scenario s = load_scenario(folder.file);
  EXPECT_EQ(s.gravity, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_TRUE(std::holds_alternative<FreeRun>(s.prediction));
  EXPECT_TRUE(s.recordings.empty());
}

TEST(Scenario, OneNoiseNumberServesEveryJointOfTheKind) {
  const ScenarioFolder folder(replaced(kScenario, "position: {a: 0.001, b: 0.002}", "position: 0.003"));
  const Scenario s = load_scenario(folder.file);
  EXPECT_EQ(s.noise.at(ChannelKind::position), (std::map<std::string, double>{{"a", 0.003}, {"b", 0.003}}));
}

TEST(Scenario, ReadsEveryKindOfPrediction) {
  const ScenarioFolder free(replaced(kScenario, "{horizon: 0.2}", "free_run"));
  EXPECT_TRUE(std::holds_alternative<FreeRun>(load_scenario(free.file).prediction));
  const ScenarioFolder inverse(replaced(kScenario, "{horizon: 0.2}", "{inverse_dynamics: {cutoff_hz: 40}}"));
  EXPECT_EQ(std::get<InverseDynamics>(load_scenario(inverse.file).prediction).cutoff_hz, 40.0);
}

TEST(Scenario, TakesEffectsAsADiagnosisWritesThem) {
  const ScenarioFolder folder(replaced(
      kScenario, "{Fc: 3.5}", "{Fc: {value: 3.5, ci95: [3.1, 3.9], unit: N m, probability: 0.9}}, probability: 0.98"));
  EXPECT_EQ(load_scenario(folder.file).effects[0].parameters.at("Fc"), 3.5);
}

TEST(Scenario, TimeIsTheFirstColumnUnlessNamed) {
  const ScenarioFolder folder(replaced(kScenario, "  time: t\n", ""));
  EXPECT_EQ(load_scenario(folder.file).channels.time, "t");
}

TEST(Scenario, WithoutRecordingsLoadedTheirFilesNeedNotExistYet) {
  const ScenarioFolder folder;
  std::filesystem::remove(folder.path() / "run.csv");
  const Scenario s = load_scenario(folder.file, {.load_recordings = false});
  EXPECT_EQ(s.recordings.size(), 2u);
  EXPECT_FALSE(s.recordings[0].data);
}

TEST(Scenario, RobotMayLieOutsideTheFolder) {
  const ScenarioFolder folder;
  folder.write("robots/two.urdf", test::kRobot);
  folder.write("case/run.csv", kRecording);
  const auto file =
      folder.write("case/scenario.yaml", replaced(kScenario, "robot: two.urdf", "robot: ../robots/two.urdf"));
  EXPECT_NO_THROW(load_scenario(file));
}

TEST(Scenario, NotesRangesThatServeForFittingAndForJudging) {
  const ScenarioFolder folder(replaced(kScenario, "from: 0.4", "from: 0.2"));
  EXPECT_THAT(load_scenario(folder.file).notes, testing::Contains(HasSubstr("the train and test ranges overlap")));
}

TEST(Scenario, LastLineCutBeforeItsCommandsIsLeftOut) {
  const ScenarioFolder folder;
  folder.write("run.csv", kRecording + "0.7,1");
  const Scenario s = load_scenario(folder.file);
  EXPECT_EQ(s.recordings[0].data->rows(), 7u);
  EXPECT_EQ(s.recordings[0].data->missing, 2u);
  EXPECT_THAT(s.notes, testing::Contains(HasSubstr("its last line stops before the end of time and commands")));
}

TEST(Scenario, LastLineCutAfterItsCommandsCountsAsMissingPositions) {
  const ScenarioFolder folder;
  folder.write("run.csv", kRecording + "0.7,1,2,0.1");
  const Scenario s = load_scenario(folder.file);
  EXPECT_EQ(s.recordings[0].data->rows(), 8u);
  EXPECT_THAT(s.notes, ElementsAre("run.csv: 4 missing values left out (q_a 2, q_b 2)"));
}

TEST(Scenario, MissingCommandsOutsideTheRangeDoNoHarm) {
  const ScenarioFolder folder(replaced(kScenario, "  - {file: run.csv, role: test, from: 0.4}\n", ""));
  folder.write("run.csv", replaced(kRecording, "0.5,1,2", "0.5,,2"));
  EXPECT_NO_THROW(load_scenario(folder.file));
}

TEST(Scenario, RangeMayEndWhereTheLastSampleIsHeldTo) {
  const ScenarioFolder folder(replaced(kScenario, "from: 0.4}", "from: 0.4, to: 0.7}"));
  EXPECT_NO_THROW(load_scenario(folder.file));
}

// --- bad scenario files ---------------------------------------------------------------------------------------------

/// A path that the system refuses is an error of the scenario, not of the program.
TEST(Scenario, NamesTooLongForAFileAreRefused) {
  const std::string name(5000, 'r');
  const ScenarioFolder robot(replaced(kScenario, "robot: two.urdf", "robot: " + name));
  EXPECT_THAT(input_error([&] { load_scenario(robot.file); }), testing::HasSubstr("a URDF or MJCF file that exists"));
  const ScenarioFolder recording(replaced(kScenario, "{file: run.csv, role: test", "{file: " + name + ", role: test"));
  EXPECT_THAT(input_error([&] { load_scenario(recording.file); }),
              testing::HasSubstr("expected a file in the scenario's folder"));
}

class SpoiledScenario : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledScenario, IsRefusedWithFilePlaceFoundAndExpected) { test::expect_refused(kScenario, GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Scenario, SpoiledScenario,
    testing::Values(
        Spoiled{"WrongFormat", "scenario/1", "scenario/2",
                "scenario.yaml:1: format: found \"lacuna-scenario/2\", expected lacuna-scenario/1"},
        Spoiled{"NoFormat", "format: lacuna-scenario/1\n", "", "found no key \"format\""},
        Spoiled{"NoName", "name: two\n", "", "found no key \"name\""},
        Spoiled{"UnknownKey", "total_mass: 3", "totalmass: 3",
                "scenario.yaml:6: totalmass: found the unknown key \"totalmass\", expected format, name, robot"},
        Spoiled{"DuplicateKey", "total_mass: 3", "name: three",
                "scenario.yaml:6: found the key \"name\" a second time"},
        Spoiled{"NoSuchRobot", "robot: two.urdf", "robot: one.urdf",
                "scenario.yaml:3: robot: found \"one.urdf\", expected a URDF or MJCF file that exists"},
        Spoiled{"RobotIsAFolder", "robot: two.urdf", "robot: .", "found a folder"},
        Spoiled{"GravityOfTwo", "[0, 0, -9.81]", "[0, -9.81]",
                "scenario.yaml:4: gravity: found a list of 2, expected three numbers"},
        Spoiled{"GravityInWords", "[0, 0, -9.81]", "down", "gravity: found \"down\", expected a list"},
        Spoiled{"NanInGravity", "[0, 0, -9.81]", "[0, 0, .nan]",
                "gravity[2]: found \".nan\", expected a finite number"},
        Spoiled{"NegativePeriod", "sample_period: 0.1", "sample_period: -0.1",
                "sample_period: found \"-0.1\", expected a number above 0"},
        Spoiled{"WrongPeriod", "sample_period: 0.1", "sample_period: 0.102",
                "run.csv:3: found a step of 0.1 s, expected the sample_period of 0.102 s within 1 %"},
        Spoiled{"ZeroTotalMass", "total_mass: 3", "total_mass: 0",
                "total_mass: found \"0\", expected a number above 0"},
        Spoiled{"TextForANumber", "gain: 10", "gain: abc",
                "scenario.yaml:8: actuators.a.gain: found \"abc\", expected a number"},
        Spoiled{"QuotedNumber", "gain: 10", "gain: \"10\"", "found the quoted text \"10\", expected a number"},
        Spoiled{"UnknownActuatedJoint", "  b: {model", "  c: {model",
                "scenario.yaml:9: actuators.c: found the joint \"c\", which the robot does not have, expected a or b"},
        Spoiled{"ActuatorWithoutModel", "{model: torque_source, gain: 5, damping: 1}", "{gain: 5}",
                "actuators.b: found no key \"model\""},
        Spoiled{"ActuatorIsAWord", "{model: torque_source, gain: 5, damping: 1}", "strong",
                "actuators.b: found \"strong\", expected a map"},
        Spoiled{"BoundsReversed", "[0.5, 2.0]", "[2.0, 0.5]",
                "identify.gain.relative_bounds: found [2, 0.5], expected [lower, upper] with lower below upper"},
        Spoiled{"BoundsEqual", "[1, 4]", "[4, 4]", "identify.a.damping: found [4, 4]"},
        Spoiled{"OneBound", "[1, 4]", "[4]", "found a list of 1, expected a list of two numbers"},
        Spoiled{"BothBounds", "{relative_bounds: [0.5, 2.0]}", "{relative_bounds: [0.5, 2.0], bounds: [1, 2]}",
                "found both bounds and relative_bounds"},
        Spoiled{"NoBounds", "{relative_bounds: [0.5, 2.0]}", "{}", "identify.gain: found no bounds"},
        Spoiled{"InfiniteBound", "[1, 4]", "[1, .inf]", "found \".inf\", expected a finite number"},
        Spoiled{"UnknownChannelKind", "  position: {a: q_a", "  positions: {a: q_a",
                "channels.positions: found the unknown key"},
        Spoiled{"UnknownChannelJoint", "{a: q_a, b: q_b}", "{a: q_a, c: q_b}",
                "channels.position.c: found the joint \"c\""},
        Spoiled{"UnknownColumn", "b: q_b}", "b: q_c}",
                "scenario.yaml:16: channels.position.b: found the column \"q_c\", which run.csv does not have, "
                "expected t, u_a, u_b, q_a or q_b"},
        Spoiled{"UnknownTimeColumn", "time: t", "time: s",
                "channels.time: found the column \"s\", which run.csv does not have"},
        Spoiled{"ColumnTwice", "b: q_b}", "b: q_a}", "found the column \"q_a\", already the position of a"},
        Spoiled{"TimeAsAChannel", "b: q_b}", "b: t}", "found the time column \"t\""},
        Spoiled{"ScaleOfZero", "scale: 2", "scale: 0",
                "channels.command.b.scale: found \"0\", expected a factor that is not 0"},
        Spoiled{"UnknownColumnKey", "scale: 2", "factor: 2",
                "channels.command.b.factor: found the unknown key \"factor\""},
        Spoiled{"UnitOfAMeasuredColumn", "b: q_b}", "b: {column: q_b, unit: deg}}",
                "channels.position.b.unit: found \"deg\", expected a unit of commands only"},
        Spoiled{"ZeroNoise", "a: 0.001", "a: 0", "noise.position.a: found \"0\", expected a number above 0"},
        Spoiled{"NoiseWithoutChannel", "  position: {a: 0.001, b: 0.002}", "  effort: 1",
                "noise.effort: found noise of a kind without channels"},
        Spoiled{"UnknownNoiseJoint", "b: 0.002", "c: 0.002", "noise.position.c: found the joint \"c\""},
        Spoiled{"UnknownRole", "role: test", "role: exam",
                "recordings[1].role: found \"exam\", expected train, validate or test"},
        Spoiled{"NoRole", ", role: test", "", "recordings[1]: found no key \"role\""},
        Spoiled{"MissingRecording", "{file: run.csv, role: test", "{file: gone.csv, role: test",
                "scenario.yaml:21: recordings[1].file: found no file \"gone.csv\""},
        Spoiled{"RangeReversed", "from: 0.0, to: 0.3", "from: 0.3, to: 0.0",
                "scenario.yaml:20: recordings[0]: found from 0.3 to 0, expected from before to"},
        Spoiled{"RangeBeyondTheEnd", "from: 0.4", "from: 0.4, to: 9",
                "recordings[1].to: found 9 s, expected a time within run.csv, 0 to 0.6 s"},
        Spoiled{"RangeBeforeTheStart", "from: 0.0, to: 0.3", "from: -5, to: 0.3", "recordings[0].from: found -5 s"},
        Spoiled{"RangeOfOneSample", "from: 0.0, to: 0.3", "from: 0.25, to: 0.35",
                "recordings[0]: found 1 samples in the range, expected at least 2"},
        Spoiled{"RecordingTwice", "role: test, from: 0.4}", "role: train, from: 0.0, to: 0.3}",
                "a second time with the same role and range"},
        Spoiled{"PathLeavesTheFolder", "{file: run.csv, role: test", "{file: ../run.csv, role: test",
                "recordings[1].file: found \"../run.csv\", expected a file in the scenario's folder or below it"},
        Spoiled{"AbsolutePath", "{file: run.csv, role: test", "{file: /etc/passwd, role: test",
                "found \"/etc/passwd\", expected a file in the scenario's folder"},
        Spoiled{"UnknownEffectPlace", "where: a", "where: z", "effects[0].where: found the joint \"z\""},
        Spoiled{"UnknownEffectRecording", "[run.csv]", "[other.csv]",
                "effects[0].recordings[0]: found \"other.csv\", expected a file listed under recordings"},
        Spoiled{"EffectWithoutName", "effect: coulomb_friction, ", "", "effects[0]: found no key \"effect\""},
        Spoiled{"EffectParameterInWords", "{Fc: 3.5}", "{Fc: much}",
                "effects[0].parameters.Fc: found \"much\", expected a number"},
        Spoiled{"EffectParameterWithoutValue", "{Fc: 3.5}", "{Fc: {unit: N}}", "found no key \"value\""},
        Spoiled{"ZeroHorizon", "{horizon: 0.2}", "{horizon: 0}",
                "prediction.horizon: found \"0\", expected a number above 0"},
        Spoiled{"InfiniteCutoff", "{horizon: 0.2}", "{inverse_dynamics: {cutoff_hz: .inf}}",
                "expected a finite number"},
        Spoiled{"TwoPredictions", "{horizon: 0.2}", "{horizon: 0.2, inverse_dynamics: {cutoff_hz: 4}}",
                "prediction: found a map of 2, expected free_run"},
        Spoiled{"UnknownPrediction", "{horizon: 0.2}", "guess", "prediction: found \"guess\", expected free_run"},
        Spoiled{"NoPositions", "  position: {a: q_a, b: q_b}\nnoise:\n  position: {a: 0.001, b: 0.002}\n", "",
                "found recordings but no channels.position"},
        Spoiled{"RecordingsAreAMap",
                "recordings:\n  - {file: run.csv, role: train, from: 0.0, to: 0.3}\n  - {file: run.csv, role: test, "
                "from: 0.4}\n",
                "recordings: {file: run.csv}\n", "recordings: found a map of 1, expected a list"},
        Spoiled{"ControlCharactersInAName", "gain: 10", "gain: \"\\e[2J\\n\"",
                "actuators.a.gain: found the quoted text \"\\x1b[2J\\n\""}),
    [](const auto& test) { return std::string(test.param.name); });

// --- bad recordings -------------------------------------------------------------------------------------------------

class SpoiledRecording : public testing::TestWithParam<Spoiled> {};

TEST_P(SpoiledRecording, IsRefusedWithFileLineAndColumn) {
  const ScenarioFolder folder;
  folder.write("run.csv", replaced(kRecording, GetParam().from, GetParam().to));
  EXPECT_THAT(input_error([&] { load_scenario(folder.file); }), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Scenario, SpoiledRecording,
    testing::Values(
        Spoiled{"NanInTime", "0.2,1,2", "nan,1,2", "run.csv:4: t: found no time, expected a number"},
        Spoiled{"NoTime", "0.2,1,2", ",1,2", "run.csv:4: t: found no time"},
        Spoiled{"TimeRunsBackwards", "0.2,1,2", "0.05,1,2",
                "run.csv:4: t: found 0.05 after 0.1, expected time that increases"},
        Spoiled{"TimeStandsStill", "0.2,1,2", "0.1,1,2", "run.csv:4: t: found 0.1 after 0.1"},
        Spoiled{"NanInCommand", "0.2,1,2", "0.2,nan,2", "run.csv:4: u_a: found no command, expected a number"},
        Spoiled{"NoCommand", "0.2,1,2", "0.2,1,", "run.csv:4: u_b: found no command"},
        Spoiled{"LineWithoutCommands", "0.2,1,2,,0.22", "0.2", "run.csv:4: u_a: found no command"},
        Spoiled{"MissingColumn", "t,u_a,u_b", "t,u_a,u_c",
                "channels.command.b: found the column \"u_b\", which run.csv does not have"},
        Spoiled{"ClockSkips", "0.5,1,2", "0.55,1,2", "run.csv:7: found a step of 0.15 s, expected the sample_period"},
        Spoiled{"ScaledOutOfRange", "0.2,1,2", "0.2,1,1e308",
                "run.csv:4: u_b: found 1e+308, expected a value that stays finite when scaled"},
        Spoiled{"PositionMissingAltogether", "0.24\n0.5,1,2,0.15,0.25\n0.6,1,2,0.16,0.26\n",
                "\n0.5,1,2,0.15,\n0.6,1,2,0.16,nan\n", "recordings[1]: found no value of \"q_b\" in the range"}),
    [](const auto& test) { return std::string(test.param.name); });

// --- hostile folders ------------------------------------------------------------------------------------------------

TEST(Scenario, SymlinkOutOfTheFolderIsRefused) {
  const ScenarioFolder folder(replaced(kScenario, "{file: run.csv, role: test", "{file: link.csv, role: test"));
  const test::TemporaryFolder outside;
  const auto target = outside.write("secret.csv", kRecording);
  std::filesystem::create_symlink(target, folder.path() / "link.csv");
  EXPECT_THAT(input_error([&] { load_scenario(folder.file); }),
              HasSubstr("recordings[1].file: found \"link.csv\", expected a file in the scenario's folder"));
}

TEST(Scenario, SymlinkedFolderInThePathIsRefused) {
  const ScenarioFolder folder(replaced(kScenario, "{file: run.csv, role: test", "{file: sub/run.csv, role: test"));
  const test::TemporaryFolder outside;
  outside.write("run.csv", kRecording);
  std::filesystem::create_directory_symlink(outside.path(), folder.path() / "sub");
  EXPECT_THAT(input_error([&] { load_scenario(folder.file); }), HasSubstr("found \"sub/run.csv\""));
}

TEST(Scenario, SymlinkWithinTheFolderIsFine) {
  const ScenarioFolder folder(replaced(kScenario, "{file: run.csv, role: test", "{file: link.csv, role: test"));
  std::filesystem::create_symlink("run.csv", folder.path() / "link.csv");
  EXPECT_NO_THROW(load_scenario(folder.file));
}

TEST(Scenario, MissingEmptyAndOversizedFilesAreNamed) {
  const test::TemporaryFolder folder;
  const auto refusal = [](const std::filesystem::path& file) { return input_error([&] { load_scenario(file); }); };
  EXPECT_THAT(refusal(folder.path() / "no.yaml"), HasSubstr("no.yaml: found no such file, expected a scenario file"));
  EXPECT_THAT(refusal(folder.path()), HasSubstr("found a folder"));
  EXPECT_THAT(refusal(folder.write("empty.yaml", "")), HasSubstr("empty.yaml: found an empty file"));
  const auto huge = folder.write("huge.yaml", "a: 1\n");
  std::filesystem::resize_file(huge, std::uintmax_t{10} << 30);
  EXPECT_THAT(refusal(huge), HasSubstr("at most 1048576 bytes"));
}

TEST(Scenario, TenGigabyteRecordingIsRefused) {
  const ScenarioFolder folder;
  std::filesystem::resize_file(folder.path() / "run.csv", std::uintmax_t{10} << 30);
  EXPECT_THAT(input_error([&] { load_scenario(folder.file); }), HasSubstr("run.csv: found 10737418240 bytes"));
}

// --- saving ---------------------------------------------------------------------------------------------------------

void expect_same(const Scenario& a, const Scenario& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.gravity, b.gravity);
  EXPECT_EQ(a.sample_period, b.sample_period);
  EXPECT_EQ(a.total_mass, b.total_mass);
  ASSERT_EQ(a.actuators.size(), b.actuators.size());
  for (std::size_t i = 0; i < a.actuators.size(); ++i) {
    EXPECT_EQ(a.actuators[i].joint, b.actuators[i].joint);
    EXPECT_EQ(a.actuators[i].model, b.actuators[i].model);
    EXPECT_EQ(a.actuators[i].parameters, b.actuators[i].parameters);
  }
  ASSERT_EQ(a.identify.size(), b.identify.size());
  for (std::size_t i = 0; i < a.identify.size(); ++i) {
    EXPECT_EQ(a.identify[i].name, b.identify[i].name);
    EXPECT_EQ(a.identify[i].relative, b.identify[i].relative);
    EXPECT_EQ(a.identify[i].lower, b.identify[i].lower);
    EXPECT_EQ(a.identify[i].upper, b.identify[i].upper);
  }
  EXPECT_EQ(a.channels.time, b.channels.time);
  for (const auto& [kind, joints] : a.channels.of)
    for (const auto& [joint, spec] : joints) {
      const ColumnSpec& other = b.channels.of.at(kind).at(joint);
      EXPECT_EQ(spec.column, other.column);
      EXPECT_EQ(spec.scale, other.scale);
      EXPECT_EQ(spec.offset, other.offset);
      EXPECT_EQ(spec.unit, other.unit);
    }
  EXPECT_EQ(a.noise, b.noise);
  ASSERT_EQ(a.recordings.size(), b.recordings.size());
  for (std::size_t i = 0; i < a.recordings.size(); ++i) {
    EXPECT_EQ(a.recordings[i].role, b.recordings[i].role);
    EXPECT_EQ(a.recordings[i].from, b.recordings[i].from);
    EXPECT_EQ(a.recordings[i].to, b.recordings[i].to);
    EXPECT_EQ(a.recordings[i].data->columns[0], b.recordings[i].data->columns[0]);
  }
  ASSERT_EQ(a.effects.size(), b.effects.size());
  for (std::size_t i = 0; i < a.effects.size(); ++i) {
    EXPECT_EQ(a.effects[i].effect, b.effects[i].effect);
    EXPECT_EQ(a.effects[i].place, b.effects[i].place);
    EXPECT_EQ(a.effects[i].parameters, b.effects[i].parameters);
    EXPECT_EQ(a.effects[i].recordings.size(), b.effects[i].recordings.size());
  }
  EXPECT_EQ(a.prediction.index(), b.prediction.index());
}

TEST(SaveScenario, LoadsToTheSameValuesBesideTheOriginal) {
  const ScenarioFolder folder;
  Scenario original = load_scenario(folder.file);
  original.name = "it's \"odd\": yes\n#1";
  original.actuators[0].parameters["gain"] = 1.0 / 3.0;
  save_scenario(original, folder.path() / "again.yaml");
  const Scenario again = load_scenario(folder.path() / "again.yaml");
  expect_same(original, again);
  EXPECT_EQ(again.recordings[0].file, "run.csv") << "files in the tree are named, not copied";
}

TEST(SaveScenario, RunsAgainFromAnyFolder) {
  const ScenarioFolder folder;
  const test::TemporaryFolder elsewhere;
  const Scenario original = load_scenario(folder.file);
  for (const auto& target : {elsewhere.path() / "out" / "scenario.diagnosed.yaml", folder.path() / "out" / "s.yaml"}) {
    save_scenario(original, target);
    const Scenario again = load_scenario(target);
    expect_same(original, again);
    EXPECT_EQ(again.effects[0].recordings[0], again.recordings[0].file);
  }
}

TEST(SaveScenario, KeepsEveryPredictionAndNoOptionalSection) {
  const ScenarioFolder folder(
      "format: lacuna-scenario/1\nname: bare\nrobot: two.urdf\nprediction: {inverse_dynamics: {cutoff_hz: 12.5}}\n");
  save_scenario(load_scenario(folder.file), folder.path() / "again.yaml");
  const Scenario again = load_scenario(folder.path() / "again.yaml");
  EXPECT_EQ(std::get<InverseDynamics>(again.prediction).cutoff_hz, 12.5);
  EXPECT_TRUE(again.actuators.empty());
}

TEST(SaveScenario, KeepsTheMotion) {
  const ScenarioFolder folder(
      "format: lacuna-scenario/1\nname: moved\nrobot: two.urdf\nchannels: {time: t, command: {a: u}}\nmotion: "
      "{duration: 2.5, position: {a: 0.3}, velocity: {a: -1}, commands: u.csv, pickup: {mass: 4, time: "
      "1}}\n");
  save_scenario(load_scenario(folder.file), folder.path() / "again.yaml");
  const Scenario again = load_scenario(folder.path() / "again.yaml");
  ASSERT_TRUE(again.motion);
  EXPECT_EQ(again.motion->duration, 2.5);
  EXPECT_EQ(again.motion->position.at("a"), 0.3);
  EXPECT_EQ(again.motion->velocity.at("a"), -1.0);
  EXPECT_EQ(again.motion->commands, "u.csv");
  EXPECT_EQ(again.motion->pickup_mass, 4.0);
  EXPECT_EQ(again.motion->pickup_time, 1.0);
}

TEST(SaveScenario, SaysWhenItCannotWrite) {
  const ScenarioFolder folder;
  const Scenario original = load_scenario(folder.file);
  EXPECT_THROW(save_scenario(original, "/proc/none/scenario.yaml"), WriteError);
}

}  // namespace
}  // namespace lacuna
