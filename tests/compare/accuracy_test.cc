#include "compare/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lacuna::test {
namespace {

std::vector<WorkPoint> points(double order, double size, double floor) {
  std::vector<WorkPoint> out;
  for (double step = 0.064; step > 2e-4; step *= 0.5) {
    WorkPoint point;
    point.step = step;
    point.error = size * std::pow(step, order) + floor;
    out.push_back(point);
  }
  return out;
}

Motion pendulum_motion() {
  return motion_of(load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/pendulum/scenario.yaml"), 1.0);
}

TEST(OrderOf, IsTheSlope) {
  EXPECT_NEAR(order_of(points(1.0, 0.5, 0.0), 1e-16), 1.0, 1e-9);
  EXPECT_NEAR(order_of(points(4.0, 100.0, 0.0), 1e-16), 4.0, 1e-9);
}

TEST(OrderOf, LooksPastRoundingAndDisorder) {
  EXPECT_NEAR(order_of(points(4.0, 100.0, 1e-15), 1e-16), 4.0, 0.01) << "the finest errors are rounding's";
  std::vector<WorkPoint> blown = points(2.0, 1.0, 0.0);
  blown[0].error = HUGE_VAL;
  EXPECT_NEAR(order_of(blown, 1e-16), 2.0, 1e-9);
  EXPECT_TRUE(std::isnan(order_of(points(1.0, 1e-20, 0.0), 1e-16))) << "nothing above the referee's own error";
  EXPECT_TRUE(std::isnan(order_of({}, 1e-16)));
}

TEST(Steps, EndAtTheSamplesAndHalve) {
  const Motion motion = pendulum_motion();
  const std::vector<double> ladder = step_ladder(motion);
  EXPECT_EQ(ladder.front(), motion.longest_step());
  for (std::size_t i = 1; i < ladder.size(); ++i) EXPECT_EQ(ladder[i], 0.5 * ladder[i - 1]);
  EXPECT_LE(common_step(motion), 1e-3);
  EXPECT_GT(common_step(motion), 0.5e-3);
}

TEST(Points, ReachTheMethodsOrder) {
  const Motion motion = pendulum_motion();
  const Referee referee = make_referee(motion, 1, nullptr);
  Runner runner("featherstone", motion);
  MethodResult common, first;
  common.name = kCommonMethod;
  measure_points(runner, motion, referee, common, nullptr);
  EXPECT_NEAR(common.order, 4.0, 0.1);
  EXPECT_EQ(common.largest_stable_step, motion.longest_step());
  EXPECT_TRUE(common.stable_at_longest);
  first.name = "semi_implicit_euler";
  first.native = true;
  measure_points(runner, motion, referee, first, nullptr);
  EXPECT_NEAR(first.order, 1.0, 0.1);
  MethodResult adaptive;
  adaptive.name = kAdaptiveMethod;
  measure_points(runner, motion, referee, adaptive, nullptr);
  EXPECT_LT(adaptive.points.back().error, 1e-8) << "at a tolerance of 1e-10 a step";
}

TEST(Affordable, CutsWhatTakesTooLong) {
  const Motion motion = pendulum_motion();
  Runner runner("featherstone", motion);
  const Method method{kCommonMethod, false};
  const Affordable all(std::string("featherstone"), motion, runner, method, 1e-3, 1e3),
      one(std::string("featherstone"), motion, runner, method, 1e-3, 0.0);
  EXPECT_EQ(&all.runner(), &runner);
  EXPECT_EQ(one.motion().times().size(), 2u) << "one interval at least";
  EXPECT_GT(one.seconds(), 0.0);
}

TEST(Runner, SaysWhatItsOwnIntegratorsCannotCarry) {
  Scenario scenario = load_scenario(std::string(LACUNA_SOURCE_DIR) + "/scenarios/pendulum/scenario.yaml");
  scenario.effects.push_back({"coulomb_friction", "swing", {{"Fc", 0.3}}, {}, "here"});
  const Motion sticking = motion_of(scenario, 1.0);
  const Runner runner("featherstone", sticking);
  EXPECT_NE(runner.refuses({"rk4", true}), "");
  EXPECT_EQ(runner.refuses({kCommonMethod, false}), "");
}

}  // namespace
}  // namespace lacuna::test
