#include "compare/conservation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/compare/scenarios.h"

namespace lacuna::test {
namespace {

/// A pendulum of 1 kg and 1 m that was left alone, written down by hand.
TEST(EnergyDrift, IsTheLargestChangeOverTheLargestKineticEnergy) {
  const Scenario scenario = load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/pendulum/scenario.yaml");
  const Motion motion = free_motion_of(scenario, motion_of(scenario, 1.0), 1.0, false, 1);
  Trajectory run;
  run.q = {{0.3}, {0.3}, {0.3}};
  run.v = {{1.0}, {2.0}, {1.0}};  // kinetic energy as 1, 4, 1
  EXPECT_NEAR(energy_drift(motion, run), 0.75, 1e-12);
  EXPECT_NEAR(momentum_drift(motion, run), 0.5, 1e-12);
  run.v[1][0] = std::nan("");
  EXPECT_EQ(energy_drift(motion, run), HUGE_VAL);
  EXPECT_EQ(momentum_drift(motion, run), HUGE_VAL);
}

TEST(JointDrift, IsOfBodiesOnlyAndErpPullsItBack) {
  const Scenario scenario = compared_scenario("free_swing");
  const Motion motion = free_motion_of(scenario, motion_of(scenario, 3.0), 0.5, true, 1);
  for (const Engine* engine : engines()) {
    if (!engine->info().available) continue;
    const std::vector<JointDrift> drift = joint_drift(engine->info().name, motion, 1e-3);
    if (engine->info().name != "ode") {
      EXPECT_TRUE(drift.empty()) << engine->info().name << " keeps joint angles";
      continue;
    }
    ASSERT_EQ(drift.size(), 2u);
    EXPECT_GT(drift[0].distance, 1e-6) << "uncorrected, bodies come apart";
    EXPECT_LT(drift[1].distance, 0.5 * drift[0].distance);
    EXPECT_LT(drift[0].distance, 0.1) << "of an arm of over a metre";
  }
}

TEST(JointGap, OfARobotAtRestIsNone) {
  const Scenario scenario = compared_scenario("cartpole");
  for (const Engine* engine : engines()) {
    if (!engine->info().available) continue;
    const auto dynamics = engine->build(scenario.robot, Eigen::Vector3d::Zero());
    const std::vector<double> q{0.2, 0.7}, v{0.0, 0.0};
    const auto gap = dynamics->native_joint_gap(q, v, 1e-3, 10, 0.0);
    EXPECT_EQ(gap.has_value(), engine->info().name == "ode");
    if (gap) {
      EXPECT_LT(gap->distance + gap->angle, 1e-12);
    }
    EXPECT_THROW(dynamics->native_joint_gap(q, v, 0.0, 10, 0.0), std::invalid_argument);
    EXPECT_THROW(dynamics->native_joint_gap(q, v, 1e-3, 10, 1.5), std::invalid_argument);
  }
}

}  // namespace
}  // namespace lacuna::test
