// A base on springs against closed forms, and against the same arm with two hinges of its own under it.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

constexpr double kBaseStiffness = 900.0, kBaseInertia = 0.7, kBaseLoss = 3.0;  // N m/rad, kg m^2, N m s/rad
const char* const kGround = "<link name='ground'/>";
/// About either hinge the base weighs 0.7 kg m^2, and what the model's own hinges weigh: a thousandth of 6.5 kg at 1
/// cm.
const char* const kHingedBase = R"(<link name='ground'/>
  <link name='rolling'><inertial><mass value='0.0065'/><inertia ixx='0.35000065' iyy='0.35' izz='0.35' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <link name='base'><inertial><mass value='0.0065'/><inertia ixx='0.35000065' iyy='0.70000065' izz='0.35000065' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='roll' type='continuous'><parent link='ground'/><child link='rolling'/><axis xyz='1 0 0'/></joint>
  <joint name='pitch' type='continuous'><parent link='rolling'/><child link='base'/><axis xyz='0 1 0'/></joint>)";
const char* const kArm = R"(
  <link name='turret'><inertial><origin xyz='0.02 0 0.1'/><mass value='4'/><inertia ixx='0.05' iyy='0.06' izz='0.04' ixy='0.002' ixz='0' iyz='0.001'/></inertial></link>
  <link name='boom'><inertial><origin xyz='0.4 0.03 0'/><mass value='2.5'/><inertia ixx='0.01' iyy='0.12' izz='0.12' ixy='0' ixz='0.003' iyz='0'/></inertial></link>
  <joint name='azimuth' type='continuous'><parent link='BASE'/><child link='turret'/><axis xyz='0 0 1'/></joint>
  <joint name='shoulder' type='continuous'><origin xyz='0.1 0 0.3'/><parent link='turret'/><child link='boom'/><axis xyz='0 1 0'/></joint>
</robot>)";

std::shared_ptr<const Robot> arm(bool hinged) {
  std::string text = std::string("<robot name='arm'>") + (hinged ? kHingedBase : kGround) + kArm;
  text.replace(text.find("BASE"), 4, hinged ? "base" : "ground");
  return Robot::from_urdf_text(text, "arm");
}

std::vector<ActuatorSpec> motors(bool hinged) {
  std::vector<ActuatorSpec> out;
  const auto spring = [&](const char* joint, double k, double c) {
    return actuator(joint, "torque_source", {{"gain", 1.0}, {"damping", c}, {"stiffness", k}, {"rest", 0.0}});
  };
  if (hinged) out = {spring("roll", kBaseStiffness, kBaseLoss), spring("pitch", kBaseStiffness, kBaseLoss)};
  for (const char* joint : {"azimuth", "shoulder"})
    out.push_back(
        actuator(joint, "torque_source", {{"gain", 12.0}, {"damping", 4.0}, {"stiffness", 30.0}, {"rest", 0.1}}));
  return out;
}

/// Tilts at which the springs carry the arm at rest at q, by iteration on the hinged arm's own statics.
std::vector<double> hinged_start(const Robot& robot, const std::vector<double>& q) {
  const auto dynamics = find_engine("simbody").build(arm(true), Eigen::Vector3d(0.0, 0.0, -9.81));
  std::vector<double> at{0.0, 0.0, q[0], q[1]}, still(4, 0.0), holding(4);
  for (int round = 0; round < 60; ++round) {
    dynamics->inverse_dynamics(at, still, still, holding);
    for (std::size_t i = 0; i < 2; ++i) at[i] = -holding[i] / kBaseStiffness;
  }
  EXPECT_EQ(robot.dof(), 4);
  return at;
}

Drive with_still_hinges(const Drive& drive) {
  Drive out = drive;
  out.u.insert(out.u.begin(), 2, std::vector<double>(drive.time.size(), 0.0));
  return out;
}

TEST(BaseCompliance, IsTheArmOnTwoHingesWithSprings) {
  const Drive drive = sine_drive(2, 2.0, 0.01, 3.0);
  const Start start{{0.2, -0.3}, {0.0, 0.0}};
  const Scenario plain = driven_scenario(arm(false), motors(false), drive, start);
  const PlantModel model = PlantModel(plain).with_effects(
      {effect("base_compliance", "arm", {{"k", kBaseStiffness}, {"I", kBaseInertia}, {"c", kBaseLoss}})});
  const auto robot = arm(true);
  const Start hinged{hinged_start(*robot, start.q), {0.0, 0.0, 0.0, 0.0}};
  const Scenario explicitly = driven_scenario(robot, motors(true), with_still_hinges(drive), hinged);
  const Experiment experiment = started_experiment(plain, start), other = started_experiment(explicitly, hinged);
  const auto expected = predict_one(PlantModel(explicitly), other, on("simbody", 0.0005)).front();
  for (const std::string& engine : available_engines()) {
    const auto found = predict_one(model, experiment, on(engine, 0.0005)).front();
    for (const int joint : {0, 1}) {
      EXPECT_LT(worst_difference(found[position_of(joint)], expected[position_of(joint + 2)]), 2e-6)
          << engine << ", joint " << joint;
    }
  }
  const auto rigid = predict_one(PlantModel(plain), experiment, on("featherstone", 0.0005)).front();
  EXPECT_GT(worst_difference(rigid[1], expected[3]), 1e-3) << "the springs show";
}

TEST(BaseCompliance, SwingsAsTwoInertiasOnTwoSprings) {
  constexpr double kJ = 0.5, kS = 40.0;  // kg m^2, N m/rad
  const auto robot = Robot::from_urdf_text(
      R"(<robot name='wheel'><link name='ground'/><link name='wheel'><inertial><mass value='3'/>
  <inertia ixx='0.4' iyy='0.5' izz='0.4' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='turn' type='continuous'><parent link='ground'/><child link='wheel'/><axis xyz='0 1 0'/></joint></robot>)",
      "wheel");
  const Start start{{0.05}, {0.0}};
  const Scenario scenario = driven_scenario(
      robot, {actuator("turn", "torque_source", {{"gain", 1.0}, {"damping", 0.0}, {"stiffness", kS}, {"rest", 0.0}})},
      constant_drive(1, 2.0, 0.01, 0.0), start);
  const PlantModel model = PlantModel(scenario).with_effects(
      {effect("base_compliance", "arm", {{"k", kBaseStiffness}, {"I", kBaseInertia}})});
  const Experiment experiment = started_experiment(scenario, start);
  const auto found = predict_one(model, experiment, on("featherstone", 0.0005)).front()[0];
  // Tilt and turn about one axis: M x'' = -K x, from x = (0, 0.05). 6e-7 kg m^2 is what the hinge weighs itself.
  Eigen::Matrix2d M, K;
  M << kBaseInertia + 6e-7 + kJ, kJ, kJ, kJ;
  K << kBaseStiffness, 0.0, 0.0, kS;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(K, M);
  const Eigen::Vector2d shares = modes.eigenvectors().transpose() * M * Eigen::Vector2d(0.0, start.q[0]);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Eigen::Array2d phase = modes.eigenvalues().array().sqrt() * (0.01 * static_cast<double>(k));
    const Eigen::Vector2d x = modes.eigenvectors() * (shares.array() * phase.cos()).matrix();
    ASSERT_NEAR(found[k], x(1), 1e-7) << "sample " << k;
  }
}

TEST(BaseCompliance, AStifferBaseEndsInOneThatStandsStill) {
  const Start start{{0.2, -0.3}, {0.0, 0.0}};
  const Scenario scenario = driven_scenario(arm(false), motors(false), sine_drive(2, 2.0, 0.01, 3.0), start);
  const PlantModel plain(scenario);
  const PlantModel model = plain.with_effects({effect("base_compliance", "arm", {})});
  const Experiment experiment = started_experiment(scenario, start);
  const auto rigid = predict_one(plain, experiment, on("featherstone", 0.01)).front()[1];
  const std::size_t k = model.find("arm.base_compliance.k");
  std::vector<std::vector<double>> values;
  const std::vector<double> stiffnesses{HUGE_VAL, 1e9, 1e6, 1e5, 1e4, 1e3};
  for (const double stiffness : stiffnesses) {
    values.push_back(model.values());
    values.back()[k] = stiffness;
  }
  // Steps of 10 ms could never follow the springs' own motion.
  const Predictions found = predict(model, experiment, values, on("featherstone", 0.01));
  EXPECT_LT(worst_difference(found[0][0][1], rigid), 1e-12);
  double before = 1e-12;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double away = worst_difference(found[i][0][1], rigid);
    EXPECT_GT(away, before) << stiffnesses[i];
    EXPECT_LT(away, 3e2 / stiffnesses[i]) << stiffnesses[i];
    before = away;
  }
}

}  // namespace
}  // namespace lacuna
