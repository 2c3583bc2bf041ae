#include "study/locked.h"

#include <gtest/gtest.h>

#include "tests/study/problems.h"

namespace lacuna {
namespace {

using namespace test;

/// rad; both plants are integrated alike, the brakes' solver rounds differently.
constexpr double kSameMotion = 1e-9;

TEST(LockedJoints, FixedArmMovesAsTheBrakedOneOnEveryEngine) {
  Scenario scenario = bundled("joint_2_table1.yaml");
  for (RecordingSpec& spec : scenario.recordings) spec.to = 3.0;
  const LockedScenario locked = with_locked_joints_fixed(scenario);
  EXPECT_EQ(locked.fixed.size(), 5u);
  EXPECT_EQ(locked.scenario.robot->dof(), 1);
  const PlantModel braked(scenario), fixed(locked.scenario);
  const Experiment a = make_experiment(scenario), b = make_experiment(locked.scenario);
  for (const std::string& engine : available_engines()) {
    SCOPED_TRACE(engine);
    const auto x = predict_one(braked, a, on(engine, 0.01)), y = predict_one(fixed, b, on(engine, 0.01));
    const double tolerance = engine == "ode" ? 1e-6 : kSameMotion;  // ODE's accelerations come from a tiny step
    EXPECT_LT(worst_difference(x[0][0], y[0][0]), tolerance);
  }
}

TEST(LockedJoints, WeldedLinksKeepTheirMassesAndTheirInfluence) {
  const Scenario scenario = bundled("joint_2_table1.yaml");
  const LockedScenario locked = with_locked_joints_fixed(scenario);
  const PlantModel model(locked.scenario);
  EXPECT_EQ(model.find("link_1.mass"), -1) << "it belongs to the world now";
  for (int i = 2; i <= 6; ++i) EXPECT_GE(model.find("link_" + std::to_string(i) + ".mass"), 0) << i;
  std::vector<double> values = model.values();
  const double before = model.inertials(values).front().mass;
  values[model.find("link_6.mass")] += 2.0;
  EXPECT_NEAR(model.inertials(values).front().mass, before + 2.0, 1e-12);
}

TEST(LockedJoints, StandWhereTheyAreFixed) {
  const std::shared_ptr<const Robot> robot = bundled_robot("hydrolek/hydrolek.urdf");
  const std::vector<double> q{0.3, -0.5, 0.8, 1.1, -0.4, 0.2, 0.1}, still(7, 0.0);
  std::vector<bool> fixed(7, true);
  fixed[2] = false;
  const std::shared_ptr<const Robot> one = robot->with_joints_fixed(fixed, q);
  ASSERT_EQ(one->dof(), 1);
  EXPECT_EQ(one->joints().front().name, robot->joints()[2].name);
  for (const std::string& engine : available_engines()) {
    SCOPED_TRACE(engine);
    std::vector<double> all(7), own(1), a(7, 0.0);
    a[2] = 0.7;
    const Eigen::Vector3d down(0.0, 0.0, -9.81);
    const auto whole_arm = find_engine(engine).build(robot, down), part = find_engine(engine).build(one, down);
    whole_arm->inverse_dynamics(q, still, a, all);
    part->inverse_dynamics(std::vector{q[2]}, std::vector{0.0}, std::vector{a[2]}, own);
    const double tolerance = engine == "ode" ? 1e-6 : 1e-9;  // ODE's accelerations come from a tiny step
    EXPECT_NEAR(own[0], all[2], tolerance * std::fabs(all[2]));
  }
}

TEST(LockedJoints, WhateverElseIsAtAJointKeepsItFree) {
  const auto fixed_of = [](auto change) {
    Scenario scenario = bundled("joint_2_table1.yaml", false);
    change(scenario);
    return with_locked_joints_fixed(scenario).fixed;
  };
  EXPECT_EQ(fixed_of([](Scenario& s) { s.total_mass = 40.0; }).size(), 0u);
  EXPECT_EQ(fixed_of([](Scenario& s) { s.effects[0].parameters["Fc"] = 50.0; }).size(), 4u);
  EXPECT_EQ(fixed_of([](Scenario& s) { s.effects[0].parameters["v0"] = 0.01; }).size(), 4u);
  EXPECT_EQ(fixed_of([](Scenario& s) { s.effects[0].recordings = {"train.csv"}; }).size(), 4u);
  EXPECT_EQ(fixed_of([](Scenario& s) { s.effects.push_back(effect("armature", "joint_1", {{"J", 1.0}})); }).size(), 4u);
  EXPECT_EQ(fixed_of([](Scenario& s) {
              s.channels.of[ChannelKind::position]["joint_3"] = {"q_3", 1.0, 0.0, ""};
            }).size(),
            4u);
}

TEST(LockedJoints, AFreeRobotIsLeftAlone) {
  const Scenario scenario = swinging();
  const LockedScenario locked = with_locked_joints_fixed(scenario);
  EXPECT_TRUE(locked.fixed.empty());
  EXPECT_EQ(locked.scenario.robot, scenario.robot);
}

}  // namespace
}  // namespace lacuna
