#include "backends/engine.h"
#include "scenarios/mjcf.h"
#include "scenarios/robot.h"
#include "tests/cli/program.h"

namespace lacuna::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Export, UrdfReadsBackWithTheMassesSet) {
  const Arm arm;
  const Outcome outcome = lacuna({"export", arm.scenario(), "--format", "urdf", "--set", "beam.mass=3.5"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto robot = Robot::from_urdf_text(outcome.out, "export");
  EXPECT_EQ(robot->moving_mass(), 3.5);
  EXPECT_THAT(outcome.out, HasSubstr("gain = 20 N m/cmd"));  // told, as the format cannot hold it
}

TEST(Export, MjcfHoldsWhatItCanAndTellsTheRest) {
  const Arm arm;
  const Outcome outcome =
      lacuna({"export", arm.scenario(), "--format", "mjcf", "--set", "elbow.coulomb_friction.Fc=4", "--set",
              "elbow.input_delay.T=0.02", "--set", "elbow.valve_offset.b=0.5", "--set", "beam.mass=4"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* part :
       {"<joint name=\"elbow\" type=\"hinge\" axis=\"0 -1 0\"", "damping=\"1\"",
        "stiffness=\"30\" springref=\"0.2616\"", "frictionloss=\"4\"", "gainprm=\"20\"", "biasprm=\"10 0 0\"",
        "mass=\"4\" fullinertia=\"0.02 0.4 0.4 0 0 0\"", "gravity=\"0 0 -9.81\"", "<!-- input_delay at elbow"})
    EXPECT_THAT(outcome.out, HasSubstr(part));
}

/// Of the bundled seven-joint arm, whose gripper slides.
TEST(Export, MjcfLoadsAgainToTheSameAccelerations) {
  const std::filesystem::path scenarios = std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios/hydrolek";
  const Outcome outcome = lacuna({"export", (scenarios / "demo/scenario.yaml").string(), "--format", "mjcf"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const MjcfModel again = read_mjcf_text(outcome.out, "demo.xml");
  const auto given = Robot::from_urdf(scenarios / "hydrolek.urdf");
  ASSERT_EQ(again.robot->dof(), given->dof());
  const Eigen::Vector3d gravity(0.0, 0.0, -9.81);
  const auto a = find_engine("featherstone").build(given, gravity);
  const auto b = find_engine("featherstone").build(again.robot, gravity);
  const std::size_t n = given->dof();
  std::vector<double> q(n), v(n), tau(n), x(n), y(n);
  for (int k = 0; k < 100; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const double phase = 0.7 * k + 1.9 * static_cast<double>(j);
      q[j] = std::sin(phase), v[j] = std::cos(1.3 * phase), tau[j] = 9.0 * std::sin(2.1 * phase);
    }
    a->forward_dynamics(q, v, tau, x);
    b->forward_dynamics(q, v, tau, y);
    for (std::size_t j = 0; j < n; ++j) EXPECT_NEAR(x[j], y[j], 1e-9 * std::max(1.0, std::fabs(x[j]))) << k << " " << j;
  }
  ASSERT_EQ(again.actuators.size(), 7u);
  EXPECT_EQ(again.actuators[1].parameters.at("gain"), 200.0);
  EXPECT_EQ(again.actuators[1].parameters.at("damping"), 231.8);
  EXPECT_EQ(again.actuators[1].parameters.at("stiffness"), 3060.0);
  EXPECT_EQ(again.actuators[1].parameters.at("rest"), 0.4);
}

TEST(Export, MjcfHoldsInertiaFilterRangeAndTilt) {
  const Arm arm;
  const Outcome outcome = lacuna({"export", arm.scenario(), "--format", "mjcf", "--set", "elbow.armature.J=0.25",
                                  "--set", "elbow.actuator_lag.T=0.05", "--set", "elbow.actuator_saturation.cap=2.5",
                                  "--set", "arm.base_tilt.roll=0.5"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  // Gravity turned by -0.5 about x: -9.81 (0, sin, cos).
  for (const char* part : {"armature=\"0.25\"", "dyntype=\"filter\" dynprm=\"0.05\"",
                           "ctrllimited=\"true\" ctrlrange=\"-2.5 2.5\"", "gravity=\"0 -4.70", "as armature"})
    EXPECT_THAT(outcome.out, HasSubstr(part));
}

TEST(Export, HostileNamesStayText) {
  const TemporaryFolder folder;
  folder.write("a.urdf", R"(<robot name='a&quot;&gt;&lt;x'><link name='base'/>
  <link name='l&lt;--'><inertial><origin xyz='0.4 0 0'/><mass value='2'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.2'/></inertial></link>
  <joint name='j--&gt;' type='continuous'><parent link='base'/><child link='l&lt;--'/><axis xyz='0 0 1'/></joint></robot>)");
  const auto scenario = folder.write("s.yaml",
                                     "format: lacuna-scenario/1\nname: ../../x\nrobot: a.urdf\n"
                                     "actuators:\n  'j-->': {model: direct_effort, gain: 1}\n");
  for (const char* format : {"mjcf", "urdf"}) {
    const Outcome outcome = lacuna({"export", scenario.string(), "--format", format, "-o", "out"}, folder.path());
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, Not(HasSubstr("..")));
    const std::string text = lacuna({"export", scenario.string(), "--format", format}).out;
    EXPECT_THAT(text, Not(HasSubstr("j-->:")));
    EXPECT_THAT(text, Not(HasSubstr("<x")));
  }
}

TEST(Export, FormatAndTargetAreChecked) {
  const Arm arm;
  expect_refused(lacuna({"export", arm.scenario()}), 2, "--format");
  expect_refused(lacuna({"export", arm.scenario(), "--format", "sdf"}), 2, "mjcf or urdf");
  // The scenario's name makes the file's: it must not fall on the robot that was read.
  expect_refused(lacuna({"export", arm.scenario(), "--format", "urdf", "-o", arm.folder().string()}), 2, "arm.urdf");
  EXPECT_EQ(lacuna({"export", arm.scenario(), "--format", "mjcf", "-o", arm.folder().string()}).code, 0);
  EXPECT_TRUE(std::filesystem::exists(arm.folder() / "arm.xml"));
}

}  // namespace
}  // namespace lacuna::test
