#include "draft/draft.h"

#include <cmath>

#include "physics/plant_model.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::TemporaryFolder;
using testing::AnyOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

const std::filesystem::path kScenarios = std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios";

const char* const kAxes = R"(<robot name='axes'><link name='a'/>
  <link name='b'><inertial><mass value='3'/><inertia ixx='.1' iyy='.1' izz='.1' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <link name='c'><inertial><origin xyz='.3 0 0'/><mass value='2'/><inertia ixx='.05' iyy='.05' izz='.05' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='slide' type='prismatic'><parent link='a'/><child link='b'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='100' velocity='9'/></joint>
  <joint name='arm' type='revolute'><parent link='b'/><child link='c'/><axis xyz='0 -1 0'/><limit lower='-3' upper='3' effort='50' velocity='9'/></joint>
  </robot>)";

/// A folder with the robot `axes` and recordings that are made here.
class DraftOfAxes : public testing::Test {
 protected:
  std::shared_ptr<const Robot> robot_ = Robot::from_urdf_text(kAxes, "axes");
  TemporaryFolder folder_;

  /// Columns as functions of time, 100 Hz, 20 s.
  using Column = std::pair<std::string, std::function<double(double)>>;
  DraftRequest request(const std::vector<Column>& columns, double tick = 1.0, double period = 0.01) const {
    auto data = std::make_shared<Recording>();
    data->names = {"t"};
    data->columns = {{}};
    for (const auto& [name, unused] : columns) data->names.push_back(name), data->columns.emplace_back();
    for (int i = 0; i <= 2000; ++i) {
      const double t = period * i;
      data->columns[0].push_back(t / tick);
      for (std::size_t c = 0; c < columns.size(); ++c) data->columns[c + 1].push_back(columns[c].second(t));
    }
    return {"axes", "axes.urdf", robot_, {{"run.csv", data}}};
  }

  /// The draft, written with its files and loaded as a scenario.
  Scenario loaded(const DraftRequest& wanted, Draft* draft = nullptr) const {
    const Draft made = draft_scenario(wanted);
    if (draft != nullptr) *draft = made;
    folder_.write("axes.urdf", kAxes);
    for (const DraftRecording& recording : wanted.recordings) {
      Recording data = *recording.data;
      for (double& t : data.columns[data.find(made.time_column)]) t *= made.time_scale;
      write_csv(folder_.path() / (made.time_scale == 1.0 ? recording.file : in_seconds(recording.file)), data);
    }
    Scenario out = load_scenario(folder_.write("scenario.yaml", made.yaml));
    const PlantModel model(out);  // its actuators are ones that there are
    return out;
  }

  static const ActuatorSpec& actuator(const Scenario& scenario, const std::string& joint) {
    for (const ActuatorSpec& spec : scenario.actuators)
      if (spec.joint == joint) return spec;
    throw std::runtime_error("no actuator of " + joint);
  }
};

double wave(double t) { return 0.4 * std::sin(1.3 * t) + 0.2 * std::sin(3.1 * t + 1.0); }
double wave_rate(double t) { return 0.52 * std::cos(1.3 * t) + 0.62 * std::cos(3.1 * t + 1.0); }
double wave_acceleration(double t) { return -0.676 * std::sin(1.3 * t) - 1.922 * std::sin(3.1 * t + 1.0); }

TEST_F(DraftOfAxes, AValveIsSeenByTheSpeedThatFollowsIt) {
  // Speeds of .02 m/s per % about a neutral command of 7.5 %.
  const auto command = [](double rate) { return 7.5 + rate / 0.02; };
  Draft draft;
  const Scenario scenario = loaded(request({{"cmd_slide", [&](double t) { return command(wave_rate(t)); }},
                                            {"cmd_arm", [&](double t) { return 20.0 * wave_rate(t + 2); }},
                                            {"len_slide", wave},
                                            {"q_arm", [](double t) { return wave(t + 2); }}}),
                                   &draft);
  const ActuatorSpec& slide = actuator(scenario, "slide");
  EXPECT_EQ(slide.model, "flow_source");
  EXPECT_NEAR(slide.parameters.at("gain"), 0.02, 0.001);
  EXPECT_NEAR(scenario.channels.of.at(ChannelKind::command).at("slide").offset, -7.5, 1.5);
  EXPECT_EQ(actuator(scenario, "arm").model, "flow_source");
  EXPECT_NEAR(actuator(scenario, "arm").parameters.at("gain"), 0.05, 0.0025);
  EXPECT_TRUE(std::holds_alternative<Windows>(scenario.prediction));
  EXPECT_THAT(draft.yaml, HasSubstr("the joint stands still at 7.6"));
  EXPECT_EQ(scenario.sample_period, 0.01);
}

TEST_F(DraftOfAxes, AMeasuredEffortIsPredictedByInverseDynamics) {
  // Of the slide alone: 5 kg move with it, and 8 N s/m resist; the arm is held still by a spring.
  const auto force = [](double t) { return 5.0 * wave_acceleration(t) + 8.0 * wave_rate(t); };
  const std::vector<Column> motion{{"q_slide", wave}, {"q_arm", [](double) { return 0.0; }}};
  std::vector<Column> columns = motion;
  columns.push_back({"f_slide", force});
  columns.push_back({"tau_arm", [](double) { return -5.9; }});
  const Scenario scenario = loaded(request(columns));
  EXPECT_EQ(actuator(scenario, "slide").model, "direct_effort");
  EXPECT_NEAR(actuator(scenario, "slide").parameters.at("damping"), 8.0, 0.4);
  EXPECT_EQ(actuator(scenario, "slide").parameters.at("gain"), 1.0);
  ASSERT_TRUE(std::holds_alternative<InverseDynamics>(scenario.prediction));
  const double cutoff = std::get<InverseDynamics>(scenario.prediction).cutoff_hz;
  EXPECT_GT(cutoff, 2.0);  // the motion goes to half a hertz
  EXPECT_LE(cutoff, 20.0);
}

TEST_F(DraftOfAxes, AMotorsCurrentIsScaledByWhatTheMassesNeed) {
  const auto current = [](double t) { return (5.0 * wave_acceleration(t) + 8.0 * wave_rate(t)) / 12.0; };
  Draft draft;
  const Scenario scenario = loaded(request({{"q_slide", wave},
                                            {"q_arm", [](double) { return 0.0; }},
                                            {"i_slide", current},
                                            {"i_arm", [](double) { return -1.0; }}}),
                                   &draft);
  EXPECT_NEAR(scenario.channels.of.at(ChannelKind::effort).at("slide").scale, 12.0, 0.3);
  EXPECT_THAT(draft.questions, Contains(HasSubstr("i_slide")));
}

TEST_F(DraftOfAxes, ASprungDriveIsSeenAndRunsFreely) {
  // 2 u = 3 kg with 2 kg on it: 5 a + 10 v + 90 (q - .1).
  const auto command = [](double t) {
    return (5.0 * wave_acceleration(t) + 10.0 * wave_rate(t) + 90.0 * (wave(t) - 0.1)) / 2.0;
  };
  const Scenario scenario =
      loaded(request({{"u_slide", command}, {"q_slide", wave}, {"q_arm", [](double) { return 0.0; }}}));
  const ActuatorSpec& slide = actuator(scenario, "slide");
  EXPECT_EQ(slide.model, "torque_source");
  EXPECT_NEAR(slide.parameters.at("gain"), 2.0, 0.1);
  EXPECT_NEAR(slide.parameters.at("stiffness"), 90.0, 5.0);
  EXPECT_NEAR(slide.parameters.at("damping"), 10.0, 1.0);
  EXPECT_NEAR(slide.parameters.at("rest"), 0.1, 0.02);
}

TEST_F(DraftOfAxes, MillisecondsAndDegreesAreConvertedAndSaid) {
  Draft draft;
  const Scenario scenario = loaded(
      request({{"u_slide", wave}, {"q_slide", wave}, {"q_arm", [](double t) { return 57.3 * wave(t) + 80.0; }}}, 1e-3),
      &draft);
  EXPECT_EQ(scenario.recordings.at(0).file, "run_in_s.csv");
  EXPECT_DOUBLE_EQ(draft.time_scale, 1e-3);
  EXPECT_EQ(scenario.sample_period, 0.01);
  EXPECT_NEAR(scenario.channels.of.at(ChannelKind::position).at("arm").scale, 0.0174532925199, 1e-12);
  EXPECT_THAT(draft.yaml, HasSubstr("GUESS: ms"));
  EXPECT_THAT(draft.questions, Contains(HasSubstr("channels.time")));
  EXPECT_THAT(draft.questions, Contains(HasSubstr("q_arm")));
}

TEST_F(DraftOfAxes, WhatIsMissingIsAskedFor) {
  Draft draft;
  const Scenario scenario = loaded(request({{"q_slide", wave}, {"q_left", wave}}), &draft);
  EXPECT_THAT(draft.yaml, HasSubstr("# ASKED: channels.position.arm"));
  EXPECT_THAT(draft.questions, Contains(HasSubstr("channels.position.arm")));
  EXPECT_THAT(draft.questions, Contains(HasSubstr("actuators.slide")));
  EXPECT_THAT(draft.questions, Contains(HasSubstr("q_left")));
  EXPECT_EQ(scenario.recordings.size(), 3u);
}

TEST_F(DraftOfAxes, WithoutAnyPositionTheRecordingsWaitAsComments) {
  Draft draft;
  const Scenario scenario = loaded(request({{"u_slide", wave}, {"temperature", wave}}), &draft);
  EXPECT_TRUE(scenario.recordings.empty());
  EXPECT_THAT(draft.yaml, HasSubstr("#   - {file: run.csv, role: train"));
  EXPECT_THAT(draft.questions, Contains(HasSubstr("channels.position")));
}

TEST_F(DraftOfAxes, HostileNamesStayText) {
  for (const std::string name :
       {"q_slide: {x}\nrecordings: []", "q_slide # \"", "'q_slide'\t", "- q_slide", "q_slide\x7f\x01"}) {
    DraftRequest wanted = request({{name, wave}, {"q_arm", wave}});
    wanted.name = name;
    const Draft draft = draft_scenario(wanted);
    folder_.write("axes.urdf", kAxes);
    const Scenario scenario = load_scenario(folder_.write("scenario.yaml", draft.yaml), {.load_recordings = false});
    EXPECT_EQ(scenario.name, name);
    EXPECT_EQ(scenario.channels.of.at(ChannelKind::position).at("slide").column, name);
    EXPECT_EQ(scenario.recordings.size(), 3u);
  }
}

TEST_F(DraftOfAxes, AClockThatGoesBackIsRefused) {
  DraftRequest wanted = request({{"q_slide", wave}});
  auto data = std::make_shared<Recording>(*wanted.recordings[0].data);
  data->columns[0][7] = 0.0;
  wanted.recordings[0].data = data;
  EXPECT_THAT(test::input_error([&] { draft_scenario(wanted); }), HasSubstr("time that increases"));
}

TEST_F(DraftOfAxes, AnUnevenClockHasNoSamplePeriod) {
  DraftRequest wanted = request({{"q_slide", wave}});
  auto data = std::make_shared<Recording>(*wanted.recordings[0].data);
  data->columns[0][7] += 0.004;
  wanted.recordings[0].data = data;
  const Scenario scenario = loaded(wanted);
  EXPECT_FALSE(scenario.sample_period.has_value());
}

/// The bundled arm's recordings, as if nobody had written its scenario.
TEST(DraftOfTheBundledArm, SaysWhatTheHandWrittenScenarioSays) {
  const Scenario given = load_scenario(kScenarios / "hydrolek/demo/scenario.yaml");
  DraftRequest request{"demo", "../hydrolek.urdf", given.robot, {}};
  for (const RecordingSpec& spec : given.recordings) request.recordings.push_back({spec.file, spec.data});
  const Draft draft = draft_scenario(request);
  const TemporaryFolder folder;
  std::filesystem::copy(kScenarios / "hydrolek/demo", folder.path() / "demo");
  std::filesystem::copy_file(kScenarios / "hydrolek/hydrolek.urdf", folder.path() / "hydrolek.urdf");
  const Scenario drafted = load_scenario(folder.write("demo/scenario.yaml", draft.yaml));
  EXPECT_EQ(drafted.sample_period, given.sample_period);
  EXPECT_TRUE(std::holds_alternative<FreeRun>(drafted.prediction));
  for (const ChannelKind kind : {ChannelKind::command, ChannelKind::position}) {
    for (const auto& [joint, column] : given.channels.of.at(kind)) {
      EXPECT_EQ(drafted.channels.of.at(kind).at(joint).column, column.column) << joint;
      EXPECT_EQ(drafted.channels.of.at(kind).at(joint).scale, 1.0) << joint;
      EXPECT_EQ(drafted.channels.of.at(kind).at(joint).offset, 0.0) << joint;
    }
  }
  ASSERT_EQ(drafted.recordings.size(), given.recordings.size());
  for (std::size_t i = 0; i < given.recordings.size(); ++i)
    EXPECT_EQ(drafted.recordings[i].role, given.recordings[i].role);
  // The truth must lie well within the bounds of the search, factors of .25 to 4.
  const Scenario truth = load_scenario(kScenarios / "hydrolek/demo/truth.yaml", {.load_recordings = false});
  ASSERT_EQ(drafted.actuators.size(), truth.actuators.size());
  for (std::size_t j = 0; j < truth.actuators.size(); ++j) {
    EXPECT_EQ(drafted.actuators[j].model, "torque_source");
    for (const char* key : {"gain", "damping", "stiffness"}) {
      const double ratio = truth.actuators[j].parameters.at(key) / drafted.actuators[j].parameters.at(key);
      EXPECT_GT(ratio, 0.4) << truth.actuators[j].joint << "." << key;
      EXPECT_LT(ratio, 2.5) << truth.actuators[j].joint << "." << key;
    }
  }
}

}  // namespace
}  // namespace lacuna
