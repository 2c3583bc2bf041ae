#include "scenarios/mjcf.h"

#include <cmath>

#include "backends/engine.h"
#include "tests/scenarios/support.h"

namespace lacuna {
namespace {

using test::input_error;
using test::TemporaryFolder;
using testing::Contains;
using testing::HasSubstr;

/// Accelerations of both robots in states all over the place, relative to the larger of them and 1.
double worst_difference(const std::shared_ptr<const Robot>& one, const std::shared_ptr<const Robot>& other) {
  const Eigen::Vector3d gravity(0.3, -0.2, -9.81);
  const auto a = find_engine("featherstone").build(one, gravity), b = find_engine("featherstone").build(other, gravity);
  const std::size_t n = one->dof();
  std::vector<double> q(n), v(n), tau(n), x(n), y(n);
  double worst = 0.0;
  for (int k = 0; k < 200; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const double phase = 0.7 * k + 1.9 * static_cast<double>(j);
      q[j] = 2.0 * std::sin(phase), v[j] = 3.0 * std::cos(1.3 * phase), tau[j] = 5.0 * std::sin(2.1 * phase);
    }
    a->forward_dynamics(q, v, tau, x);
    b->forward_dynamics(q, v, tau, y);
    for (std::size_t j = 0; j < n; ++j)
      worst = std::max(worst, std::fabs(x[j] - y[j]) / std::max(1.0, std::max(std::fabs(x[j]), std::fabs(y[j]))));
  }
  return worst;
}

constexpr double kSameAccelerations = 1e-9;  // what the contract asks

const char* const kUrdf = R"(<robot name='two'><link name='ground'/>
  <link name='upper'><inertial><origin xyz='.3 .01 0' rpy='0 0 .5'/><mass value='4'/><inertia ixx='.02' iyy='.2' izz='.21' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <link name='fore'><inertial><origin xyz='.2 0 .05'/><mass value='2'/><inertia ixx='.01' iyy='.05' izz='.055' ixy='.001' ixz='0' iyz='-.002'/></inertial></link>
  <link name='rod'><inertial><origin xyz='0 0 .1'/><mass value='.5'/><inertia ixx='.003' iyy='.003' izz='.0004' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <link name='ball'><inertial><mass value='.3'/><inertia ixx='.0003' iyy='.0003' izz='.0003' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='shoulder' type='revolute'><parent link='ground'/><child link='upper'/><origin xyz='0 0 .4' rpy='0 .5235987755982988 0'/><axis xyz='0 -1 0'/><limit lower='-1' upper='1.5' effort='9' velocity='9'/></joint>
  <joint name='elbow' type='continuous'><parent link='upper'/><child link='fore'/><origin xyz='.6 0 0' rpy='1.5707963267948966 0 0'/><axis xyz='0 0 1'/></joint>
  <joint name='slide' type='prismatic'><parent link='fore'/><child link='rod'/><origin xyz='.4 0 0' rpy='0 1.0471975511965976 0'/><axis xyz='0 0 1'/><limit lower='0' upper='.2' effort='9' velocity='9'/></joint>
  <joint name='weld' type='fixed'><parent link='rod'/><child link='ball'/><origin xyz='0 0 .25'/></joint>
</robot>)";

/// The same in degrees, with classes, anchors away from the bodies' own frames, and a ball weighed by its geom.
const char* const kMjcf = R"(<mujoco model="two"><option gravity="0 0 -1.62"/>
  <default><joint damping="2"/><default class="strong"><joint damping="7" armature="0.3" axis="0 -1 0"/></default></default>
  <worldbody><body name="upper" pos="0 0 .4" euler="0 30 0" childclass="strong">
      <inertial pos=".3 .01 0" euler="0 0 28.64788975654116" mass="4" diaginertia=".02 .2 .21"/>
      <joint name="shoulder" range="-57.29577951308232 85.94366926962348" limited="true" springref="90" stiffness="12"/>
      <body name="fore" pos=".5 0 0" quat="0.7071067811865476 0.7071067811865476 0 0">
        <inertial pos=".3 0 .05" mass="2" fullinertia=".01 .05 .055 .001 0 -.002"/>
        <joint name="elbow" class="main" axis="0 0 2" pos=".1 0 0" frictionloss="0.4"/>
        <body name="rod" pos=".5 0 0" axisangle="0 1 0 60">
          <inertial pos="0 0 .1" mass=".5" diaginertia=".003 .003 .0004"/>
          <joint name="slide" type="slide" class="main" range="0 .2"/>
          <body name="ball" pos="0 0 .25"><geom size=".05" mass=".3"/></body>
        </body></body></body></worldbody>
  <actuator><motor joint="shoulder" gear="40"/><position joint="elbow" kp="50"/></actuator></mujoco>)";

TEST(Mjcf, IsTheSameRobotAsItsUrdf) {
  // The elbow's joint lies at (.1, 0, 0) of its body, whose origin is .5 along: .6 as in the URDF.
  const MjcfModel model = read_mjcf_text(kMjcf, "two.xml");
  const auto urdf = Robot::from_urdf_text(kUrdf, "two.urdf");
  ASSERT_EQ(model.robot->dof(), 3);
  for (int j = 0; j < 3; ++j) {
    EXPECT_EQ(model.robot->joints()[j].name, urdf->joints()[j].name);
    EXPECT_DOUBLE_EQ(model.robot->joints()[j].lower, urdf->joints()[j].lower);
  }
  EXPECT_LT(worst_difference(model.robot, urdf), kSameAccelerations);
  // And what is written as URDF is still the same.
  EXPECT_LT(worst_difference(Robot::from_urdf_text(to_urdf(*model.robot), "again"), urdf), kSameAccelerations);
  EXPECT_EQ(model.gravity.z(), -1.62);
}

TEST(Mjcf, ADifferentRobotIsToldApart) {
  std::string other = kMjcf;
  other.replace(other.find("mass=\"2\""), 8, "mass=\"3\"");
  EXPECT_GT(worst_difference(read_mjcf_text(other, "x").robot, Robot::from_urdf_text(kUrdf, "x")), 1e-3);
}

TEST(Mjcf, DampersSpringsFrictionAndGainsBecomeThePlainModel) {
  const MjcfModel model = read_mjcf_text(kMjcf, "two.xml");
  ASSERT_EQ(model.actuators.size(), 3u);
  const auto& shoulder = model.actuators[0];
  EXPECT_EQ(shoulder.model, "torque_source");
  EXPECT_EQ(shoulder.parameters.at("gain"), 40.0);
  EXPECT_EQ(shoulder.parameters.at("damping"), 7.0);  // of its class
  EXPECT_EQ(shoulder.parameters.at("stiffness"), 12.0);
  EXPECT_NEAR(shoulder.parameters.at("rest"), 1.5707963267948966, 1e-12);
  const auto& elbow = model.actuators[1];
  EXPECT_EQ(elbow.parameters.at("gain"), 50.0);
  EXPECT_EQ(elbow.parameters.at("stiffness"), 50.0);
  EXPECT_EQ(elbow.parameters.at("damping"), 2.0);
  EXPECT_EQ(model.actuators[2].model, "direct_effort");
  ASSERT_EQ(model.effects.size(), 2u);
  EXPECT_EQ(model.effects[0].effect, "armature");
  EXPECT_EQ(model.effects[0].parameters.at("J"), 0.3);
  EXPECT_EQ(model.effects[1].effect, "coulomb_friction");
  EXPECT_EQ(model.effects[1].place, "elbow");
}

TEST(Mjcf, WeighsGeomsOfSimpleShape) {
  const auto inertial = [](const std::string& geom) {
    const MjcfModel model =
        read_mjcf_text("<mujoco><worldbody><body><joint/>" + geom + "</body></worldbody></mujoco>", "g");
    return model.robot->links()[1].inertial;
  };
  // Closed forms; of a capsule the limit of a long thin one is a rod, m L^2 / 12.
  EXPECT_NEAR(inertial("<geom type='box' size='.1 .2 .3'/>").mass, 48.0, 1e-9);
  EXPECT_NEAR(inertial("<geom type='box' size='.1 .2 .3' mass='6'/>").inertia(0, 0), 6.0 / 3.0 * (.04 + .09), 1e-12);
  EXPECT_NEAR(inertial("<geom type='cylinder' size='.1 .2' mass='3'/>").inertia(2, 2), 0.015, 1e-12);
  EXPECT_NEAR(inertial("<geom type='cylinder' size='.1 .2' mass='3'/>").inertia(0, 0), 3.0 * (.03 + .16) / 12.0, 1e-12);
  EXPECT_NEAR(inertial("<geom type='capsule' size='1e-4' fromto='0 0 0 2 0 0' mass='3'/>").inertia(1, 1), 1.0, 1e-3);
  EXPECT_NEAR(inertial("<geom type='capsule' size='1e-4' fromto='0 0 0 2 0 0' mass='3'/>").com.x(), 1.0, 1e-12);
  // A capsule without length is a sphere.
  EXPECT_NEAR(inertial("<geom type='capsule' size='.1 1e-9' mass='5'/>").inertia(0, 0), 0.02, 1e-8);
}

std::string refusal(const std::string& body, const std::string& rest = "") {
  return input_error([&] {
    read_mjcf_text("<mujoco><worldbody><body name='b'><inertial mass='1' diaginertia='1 1 1'/>\n" + body +
                       "</body></worldbody>" + rest + "</mujoco>",
                   "r.xml");
  });
}

TEST(Mjcf, WhatIsNotUnderstoodIsRefusedByName) {
  EXPECT_THAT(refusal("<joint/><joint/>"), HasSubstr("second joint"));
  EXPECT_THAT(refusal("<joint type='ball' name='hip'/>"), HasSubstr("r.xml:2: joint hip: found a joint of type"));
  EXPECT_THAT(refusal("<freejoint/>"), HasSubstr("free joint"));
  EXPECT_THAT(refusal("<joint ref='3'/>"), HasSubstr("ref"));
  EXPECT_THAT(refusal("<include file='/etc/passwd'/>"), HasSubstr("include"));
  EXPECT_THAT(refusal("<joint/>", "<equality><weld name='w'/></equality>"), HasSubstr("weld w"));
  EXPECT_THAT(refusal("<joint/>", "<tendon><fixed name='t'/></tendon>"), HasSubstr("tendon"));
  EXPECT_THAT(refusal("<joint/>", "<compiler settotalmass='3'/>"), HasSubstr("settotalmass"));
  EXPECT_THAT(refusal("<joint class='none'/>"), HasSubstr("none"));
  EXPECT_THAT(refusal("<joint axis='0 0 0'/>"), HasSubstr("axis"));
  EXPECT_THAT(refusal("<joint axis='0 1'/>"), HasSubstr("3 finite numbers"));
  EXPECT_THAT(refusal("<joint axis='0 nan 1'/>"), HasSubstr("3 finite numbers"));
  EXPECT_THAT(refusal("<composite/>"), HasSubstr("composite"));
  EXPECT_THAT(input_error([] { read_mjcf_text("<robot/>", "r.xml"); }), HasSubstr("mujoco"));
  EXPECT_THAT(input_error([] {
                read_mjcf_text(
                    "<mujoco><worldbody><body><joint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>", "r");
              }),
              HasSubstr("mesh"));
}

TEST(Mjcf, WhatIsLeftOutIsNoted) {
  std::vector<std::string> notes;
  read_mjcf_text(
      "<mujoco><worldbody><body><inertial mass='1' diaginertia='1 1 1'/><joint name='j'/></body></worldbody>"
      "<contact><exclude/></contact><actuator><muscle name='m' joint='j'/></actuator></mujoco>",
      "n", &notes);
  EXPECT_THAT(notes, Contains(HasSubstr("contacts")));
  EXPECT_THAT(notes, Contains(HasSubstr("actuator m")));
}

TEST(Mjcf, AScenarioTakesItAndSaysMore) {
  const TemporaryFolder folder;
  folder.write("two.xml", kMjcf);
  const std::string head = "format: lacuna-scenario/1\nname: two\nrobot: two.xml\n";
  const Scenario plain = load_scenario(folder.write("plain.yaml", head));
  EXPECT_EQ(plain.actuators.size(), 3u);
  EXPECT_EQ(plain.effects.size(), 2u);
  EXPECT_EQ(plain.gravity.z(), -1.62);
  const Scenario more = load_scenario(folder.write(
      "more.yaml", head + "gravity: [0, 0, -9.81]\nactuators:\n  elbow: {model: direct_effort, gain: 3}\neffects:\n"
                          "  - {effect: armature, where: shoulder, parameters: {J: 0.7}}\n"));
  EXPECT_EQ(more.gravity.z(), -9.81);
  ASSERT_EQ(more.actuators.size(), 3u);
  EXPECT_EQ(more.actuators.back().model, "direct_effort");
  ASSERT_EQ(more.effects.size(), 2u);
  EXPECT_EQ(more.effects.back().parameters.at("J"), 0.7);
}

TEST(Mjcf, XacroIsRefusedWithTheCommandToRun) {
  const TemporaryFolder folder;
  const auto file = folder.write("arm.urdf.xacro", "<robot xmlns:xacro='x'><xacro:include filename='y'/></robot>");
  EXPECT_THAT(input_error([&] { read_robot_file(file); }), HasSubstr("`xacro arm.urdf.xacro > robot.urdf`"));
}

TEST(Mjcf, WhatChangesTheDynamicsAndIsNotModelledIsRefused) {
  EXPECT_THAT(refusal("<joint springdamper='.1 1'/>"), HasSubstr("springdamper"));
  EXPECT_THAT(refusal("<joint/>", "<option density='1.2'/>"), HasSubstr("density"));
  EXPECT_THAT(refusal("<joint/>", "<option><flag gravity='disable'/></option>"), HasSubstr("gravity disabled"));
  EXPECT_THAT(refusal("<joint/><geom size='.1' shellinertia='true'/>"), HasSubstr("shellinertia"));
  const auto body = [](const std::string& attributes, const std::string& inertial) {
    return input_error([&] {
      read_mjcf_text("<mujoco><worldbody><body " + attributes + "><joint/>" + inertial + "</body></worldbody></mujoco>",
                     "r");
    });
  };
  EXPECT_THAT(body("gravcomp='1'", "<inertial mass='1' diaginertia='1 1 1'/>"), HasSubstr("gravcomp"));
  EXPECT_THAT(body("", "<inertial diaginertia='1 1 1'/>"), HasSubstr("no mass"));
}

TEST(Mjcf, APositionActuatorsDampingIsTaken) {
  const MjcfModel model = read_mjcf_text(
      "<mujoco><worldbody><body><inertial mass='1' diaginertia='1 1 1'/><joint name='j' damping='1'/></body>"
      "</worldbody><actuator><position joint='j' kp='50' kv='4' gear='2'/></actuator></mujoco>",
      "r");
  EXPECT_EQ(model.actuators.at(0).parameters.at("damping"), 1.0 + 2.0 * 2.0 * 4.0);
}

TEST(Mjcf, DefaultsAreBounded) {
  std::string many = "<mujoco><default>";
  for (int k = 0; k < 2000; ++k) many += "<default class='a" + std::to_string(k) + "'/>";
  EXPECT_THAT(input_error([&] { read_mjcf_text(many + "</default><worldbody/></mujoco>", "r"); }),
              HasSubstr("one class more"));
  const std::string large(100'000, '1');
  EXPECT_THAT(input_error([&] {
                read_mjcf_text("<mujoco><default><joint damping='" + large + "'/></default><worldbody/></mujoco>", "r");
              }),
              HasSubstr("a default of 100000 bytes"));
}

TEST(Mjcf, AScenariosActuatorDoesNotKeepTheFilesLag) {
  const TemporaryFolder folder;
  folder.write("lag.xml",
               "<mujoco><worldbody><body><inertial mass='1' diaginertia='1 1 1'/><joint name='j'/></body></worldbody>"
               "<actuator><general joint='j' dyntype='filter' dynprm='.1'/></actuator></mujoco>");
  const std::string head = "format: lacuna-scenario/1\nname: lag\nrobot: lag.xml\n";
  EXPECT_EQ(load_scenario(folder.write("file.yaml", head)).effects.size(), 1u);
  EXPECT_TRUE(load_scenario(folder.write("own.yaml", head + "actuators:\n  j: {model: direct_effort, gain: 3}\n"))
                  .effects.empty());
}

TEST(Mjcf, AnUrdfThatXacroMadeIsTaken) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("arm.urdf",
                   "<robot name='r'><!-- <xacro:macro name='m'/> --><link name='a'/><link name='b'><inertial>"
                   "<mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
                   "<joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>");
  EXPECT_EQ(read_robot_file(file).robot->dof(), 1);
}

}  // namespace
}  // namespace lacuna
