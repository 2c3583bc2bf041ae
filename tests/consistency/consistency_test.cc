// What `lacuna compare` measures, at small size, on every engine and every bundled scenario of comparison: the checks
// that fail where an engine, its adapter or a common method is changed for the worse. A failure names engine, scenario,
// the worst value and the instant.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scenarios/error.h"
#include "tests/compare/scenarios.h"
#include "tests/conformance/worst.h"
#include "compare/accuracy.h"
#include "compare/agreement.h"
#include "compare/conservation.h"
#include "compare/repeatability.h"

namespace lacuna::test {
namespace {

/// Accelerations relative to their norm: rounding, 1e-16, times the condition of these robots' mass matrices, up to 1e5
/// for the chain of thirty, with two decades to spare (as in tests/conformance).
constexpr double kAcceleration = 1e-9;
/// m, and entries of rotation matrices: thirty roundings.
constexpr double kPose = 1e-9;
/// rad (m), common runs of two engines over a quarter of a second: accelerations that differ by rounding, spread by the
/// motion's own sensitivity, e^2 or so in that time; stick and slip fall into the same steps.
constexpr double kSameMotion = 1e-9;
/// rad (m), a common run at a step of 1 ms against the referee: Kutta's error, h^4 times a fifth derivative of up to
/// 1e5 rad/s^5 (the spinning wrist, the stiff joint at 1,400 rad/s is held apart).
constexpr double kTrajectory = 1e-6;
/// The stiff joint swings at 770 rad/s: (w h)^5/120 a step, 250 steps, of 0.01 rad.
constexpr double kStiffTrajectory = 2e-3;
/// Of the largest kinetic energy in a quarter of a second of free motion, Kutta's steps of 1 ms: (w h)^5 with w up to
/// 40 rad/s.
constexpr double kDrift = 1e-6;
constexpr double kSeconds = 0.25;
constexpr int kStates = 40;

const std::vector<std::string> kScenarios{
    "arm_multisine",  "arm_staircase",  "arm_step", "cartpole",       "double_pendulum", "free_swing", "long_chain_002",
    "long_chain_010", "long_chain_030", "pickup",   "spinning_wrist", "stick_slip",      "stiff_joint"};

/// The first quarter of a second; of the pickup the quarter about it.
Motion short_motion(const Scenario& scenario) {
  Scenario early = scenario;
  if (early.motion->pickup_mass) early.motion->pickup_time = 0.128;
  return motion_of(early, 5.0).first(kSeconds);
}

class Consistency : public testing::TestWithParam<std::tuple<std::string, std::string>> {
 protected:
  void SetUp() override {
    const EngineInfo info = find_engine(engine()).info();
    if (!info.available) GTEST_SKIP() << info.name << " is " << info.reason;
  }
  std::string engine() const { return std::get<0>(GetParam()); }
  std::string name() const { return std::get<1>(GetParam()); }
  Worst worst() const { return {engine(), name()}; }
};

TEST_P(Consistency, AccelerationsAndPosesAreFeatherstones) {
  const Motion motion = short_motion(compared_scenario(name()));
  EngineComparison found;
  found.engine = engine();
  measure_agreement(motion, 1, 1, nullptr, found, kStates);
  Worst difference = worst(), error = worst(), pose = worst();
  difference.see(found.acceleration_difference.value, found.acceleration_difference.where);
  error.see(found.acceleration_error.value, found.acceleration_error.where + ", extended precision");
  pose.see(found.pose_difference.value, found.pose_difference.where);
  EXPECT_TRUE(difference.at_most(kAcceleration));
  EXPECT_TRUE(error.at_most(kAcceleration));
  EXPECT_TRUE(pose.at_most(kPose));
}

TEST_P(Consistency, TheCommonMethodFollowsTheReferee) {
  const Motion motion = short_motion(compared_scenario(name()));
  const Referee referee = make_referee(motion, 1, nullptr);
  ASSERT_EQ(referee.trusted, referee.times.size()) << name() << ": the referee is not sure of itself";
  const double step = common_step(motion);
  const Trajectory run = Runner(engine(), motion).run({kCommonMethod, false}, step);
  const ErrorSeries series = error_of(run, referee);
  Worst error = worst(), apart = worst();
  error.see(series.worst, fmt::format("{} s, joint {}", series.worst_time, series.worst_joint));
  EXPECT_TRUE(error.at_most(name() == "stiff_joint" ? kStiffTrajectory : kTrajectory));
  const Trajectory ours = Runner("featherstone", motion).run({kCommonMethod, false}, step);
  for (std::size_t k = 0; k < run.q.size(); ++k) {
    for (std::size_t j = 0; j < run.q[k].size(); ++j)
      apart.see(std::abs(run.q[k][j] - ours.q[k][j]), fmt::format("{} s, joint {}", referee.times[k], j));
  }
  EXPECT_TRUE(apart.at_most(kSameMotion)) << "common runs of " << engine() << " and featherstone";
}

TEST_P(Consistency, FreeMotionKeepsEnergyAndMomentum) {
  const Scenario scenario = compared_scenario(name());
  const Motion motion = motion_of(scenario, 5.0);
  const Motion falling = free_motion_of(scenario, motion, kSeconds, true, 1),
               floating = free_motion_of(scenario, motion, kSeconds, false, 1);
  const Method common{kCommonMethod, false};
  const double step = common_step(falling);
  Worst energy = worst(), momentum = worst();
  energy.see(energy_drift(falling, Runner(engine(), falling).run(common, step)), "any instant of the free motion");
  momentum.see(momentum_drift(floating, Runner(engine(), floating).run(common, step)), "any instant without gravity");
  EXPECT_TRUE(energy.at_most(kDrift));
  EXPECT_TRUE(momentum.at_most(kDrift));
}

TEST_P(Consistency, EveryIntegratorRepeatsAndRestoresBitByBit) {
  const Scenario scenario = compared_scenario(name());
  const Motion motion = free_motion_of(scenario, motion_of(scenario, 5.0), 0.064, true, 1);
  for (const Method& method : methods_of(engine())) {
    if (!method.native && method.name == kAdaptiveMethod) continue;
    MethodResult found;
    found.name = method.name;
    found.native = method.native;
    measure_repeatability(engine(), motion, 4e-3, found);
    EXPECT_TRUE(found.repeats) << engine() << ", " << name() << ", " << method.name << ": a second run differs";
    EXPECT_TRUE(found.restores) << engine() << ", " << name() << ", " << method.name
                                << ": differs after 0.032 s were saved and restored";
  }
}

/// Own integrators, free motion of the arm and of the double pendulum: at least the order that they claim.
class NativeOrder : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(NativeOrder, IsWhatTheIntegratorClaims) {
  const auto& [engine, name] = GetParam();
  const EngineInfo info = find_engine(engine).info();
  if (!info.available) GTEST_SKIP() << info.name << " is " << info.reason;
  const std::map<std::string, double> claims{{"rk4", 4},
                                             {"runge_kutta_merson", 4},
                                             {"runge_kutta_feldberg", 4},
                                             {"runge_kutta_3", 3},
                                             {"quickstep", 0}};  // quickstep stops its sweeps early
  const Scenario scenario = compared_scenario(name);
  const Motion motion = free_motion_of(scenario, motion_of(scenario, 5.0), kSeconds, true, 1);
  const Referee referee = make_referee(motion, 1, nullptr);
  for (const std::string& integrator : info.native_integrators) {
    const double claimed = claims.contains(integrator) ? claims.at(integrator) : 1.0;
    if (claimed == 0.0) continue;
    Runner runner(engine, motion);
    std::vector<WorkPoint> points;
    for (const double step : {8e-3, 4e-3, 2e-3, 1e-3}) {
      WorkPoint point;
      point.step = step;
      point.error = error_of(runner.run({integrator, true}, step), referee).worst;
      points.push_back(point);
    }
    // Less what the next order blurs.
    EXPECT_GT(order_of(points, referee.record.error), claimed - 0.35)
        << engine << ", " << name << ", " << integrator << ": error " << points.back().error << " at 1 ms";
  }
}

std::string test_name(const testing::TestParamInfo<std::tuple<std::string, std::string>>& info) {
  return std::get<0>(info.param) + "_" + std::get<1>(info.param);
}
std::vector<std::string> engine_names() {
  std::vector<std::string> names;
  for (const Engine* engine : engines()) names.push_back(engine->info().name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Bundled, Consistency,
                         testing::Combine(testing::ValuesIn(engine_names()), testing::ValuesIn(kScenarios)), test_name);
INSTANTIATE_TEST_SUITE_P(Bundled, NativeOrder,
                         testing::Combine(testing::ValuesIn(engine_names()),
                                          testing::Values(std::string("free_swing"), std::string("double_pendulum"))),
                         test_name);

// MuJoCo's XML reader stops at some 95 bodies in a row: refused in words, never a crash; all others hold the chain.
TEST(LongChain, IsHeldOrRefusedInWords) {
  const Scenario scenario = compared_scenario("long_chain_100");
  for (const Engine* engine : engines()) {
    if (!engine->info().available) continue;
    try {
      engine->build(scenario.robot, scenario.gravity);
      EXPECT_NE(engine->info().name, "mujoco") << "by now it holds a hundred links: say so in the documentation";
    } catch (const WorkError& error) {
      EXPECT_EQ(engine->info().name, "mujoco") << error.what();
      EXPECT_NE(std::string(error.what()).find("cannot hold robot"), std::string::npos) << error.what();
    }
  }
}

// The one test of what the pickup must keep lies in tests/compare; here: that it changes the motion, and alike.
TEST(PickupConsistency, ChangesTheMotionOnEveryEngineAlike) {
  Scenario scenario = compared_scenario("pickup");
  const Motion with = motion_of(scenario, 5.0).first(0.9);
  scenario.motion->pickup_mass.reset();
  const Motion without = motion_of(scenario, 5.0).first(0.9);
  const Method common{kCommonMethod, false};
  const Trajectory reference = Runner("featherstone", with).run(common, 1e-3);
  EXPECT_GT(std::abs(reference.q.back()[1] - Runner("featherstone", without).run(common, 1e-3).q.back()[1]), 1e-3);
  for (const Engine* engine : engines()) {
    if (!engine->info().available) continue;
    Worst apart(engine->info().name, "pickup");
    const Trajectory run = Runner(engine->info().name, with).run(common, 1e-3);
    for (std::size_t j = 0; j < 6; ++j) apart.see(std::abs(run.q.back()[j] - reference.q.back()[j]), "0.9 s");
    EXPECT_TRUE(apart.at_most(kSameMotion));
  }
}

}  // namespace
}  // namespace lacuna::test
