#include "compare/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>

#include "backends/engine.h"
#include "tests/compare/scenarios.h"
#include "tests/scenarios/support.h"

namespace lacuna::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Motion, OfABareRobotStartsEveryJointAtARadian) {
  const Scenario scenario = load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/cartpole/scenario.yaml");
  const Motion motion = motion_of(scenario, 2.0);
  EXPECT_THAT(motion.phases.front().segment.q0, ElementsAre(0.1, 1.0)) << "a slide, a hinge";
  EXPECT_DOUBLE_EQ(motion.duration(), 2.0);
  EXPECT_FALSE(motion.commanded);
  EXPECT_DOUBLE_EQ(motion.longest_step(), 2.0 / 32) << "of at most kFreeSpacing, in whole intervals";
}

TEST(Motion, FollowsTheCommandsThatTheScenarioNames) {
  const Motion motion = motion_of(compared_scenario("arm_step"), 1.0);
  EXPECT_TRUE(motion.commanded);
  EXPECT_DOUBLE_EQ(motion.duration(), 4.0) << "stated, so not cut to a second";
  EXPECT_EQ(motion.phases.front().segment.q0[1], 0.4);
  EXPECT_EQ(motion.phases.front().segment.commands->value[1][100], 4.0);
  EXPECT_NEAR(motion.longest_step(), 0.01, 1e-12);
}

TEST(Motion, ItsFirstSecondsAreThoseOfTheWhole) {
  const Motion whole = motion_of(compared_scenario("pickup"), 5.0);
  ASSERT_EQ(whole.phases.size(), 2u);
  const Motion start = whole.first(0.3), all = whole.first(99.0);
  EXPECT_EQ(start.phases.size(), 1u);
  const std::vector<double> times = start.times(), of_whole = whole.times();
  EXPECT_NEAR(times.back(), 0.3, whole.longest_step());
  for (std::size_t k = 0; k < times.size(); ++k) EXPECT_EQ(times[k], of_whole[k]);
  EXPECT_EQ(all.times(), of_whole);
  EXPECT_EQ(whole.first(0.0).times().size(), 2u) << "one interval at least";
}

TEST(Motion, WithoutReadings) {
  Scenario scenario = compared_scenario("free_swing");
  scenario.effects.push_back({"sensor_offset", "joint_2", {{"o", 0.3}}, {}, "here"});
  EXPECT_TRUE(motion_of(scenario, 1.0).model.effects().empty());
}

// A mass at rest has no momentum: what the joints carry before, they carry after.
TEST(Pickup, KeepsTheJointsMomenta) {
  const Motion motion = motion_of(compared_scenario("pickup"), 5.0);
  const std::vector<double> q{0.1, 0.5, -0.4, 0.2, 0.3, 0.0}, v{0.5, -1.0, 0.7, 0.2, -0.4, 1.0};
  const auto &before = motion.phases[0].values, &after = motion.phases[1].values;
  const std::vector<double> slower = speeds_after_pickup(motion.model, before, after, q, v);
  for (const Engine* engine : engines()) {
    if (!engine->info().available) continue;
    const auto momentum = [&](const std::vector<double>& values, const std::vector<double>& speeds) -> Eigen::VectorXd {
      const auto dynamics = engine->build(motion.model.robot_ptr(), motion.model.gravity());
      const std::vector<Inertial> bodies = motion.model.inertials(values);
      for (int i = 0; i < 6; ++i) dynamics->set_inertial(i, bodies[i]);
      Eigen::MatrixXd mass;
      dynamics->mass_matrix(q, mass);
      return mass * Eigen::Map<const Eigen::VectorXd>(speeds.data(), 6);
    };
    EXPECT_LT((momentum(before, v) - momentum(after, slower)).norm(), 1e-9) << engine->info().name;  // of some tens
  }
  EXPECT_NE(slower, v);
}

TEST(Pickup, OfAPlantWithStatesIsRefused) {
  Scenario scenario = compared_scenario("pickup");
  scenario.effects.push_back({"joint_compliance", "joint_2", {}, {}, "here"});
  EXPECT_THROW(motion_of(scenario, 5.0), InputError);
}

TEST(Pickup, AfterTheEndIsRefused) {
  Scenario scenario = compared_scenario("pickup");
  scenario.motion->pickup_time = 9.0;
  try {
    motion_of(scenario, 5.0);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("pickup.time: found 9 s"));
  }
}

TEST(FreeMotion, HasSpeedButNoDrive) {
  const Scenario scenario = compared_scenario("arm_step");
  const Motion motion = motion_of(scenario, 5.0);
  const Motion free = free_motion_of(scenario, motion, 1.0, true, 1),
               again = free_motion_of(scenario, motion, 1.0, true, 1),
               other = free_motion_of(scenario, motion, 1.0, false, 2);
  EXPECT_EQ(free.phases[0].segment.q0, motion.phases[0].segment.q0);
  EXPECT_EQ(free.phases[0].segment.v0, again.phases[0].segment.v0);
  EXPECT_NE(free.phases[0].segment.v0, other.phases[0].segment.v0) << "another seed";
  for (const Component& actuator : free.model.actuators()) EXPECT_EQ(actuator.type, -1);
  EXPECT_EQ(other.model.gravity().norm(), 0.0);
}

}  // namespace
}  // namespace lacuna::test
