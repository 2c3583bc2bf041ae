// The time loop: order of convergence, held commands, irregular clocks, friction that stays at rest.
#include <gtest/gtest.h>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

std::shared_ptr<const Robot> pendulum() { return bundled_robot("pendulum/pendulum.urdf"); }

/// Largest error of the position over a run, against a run with steps 32 times shorter than the shortest.
std::vector<double> errors_of_steps(const PlantModel& model, const Experiment& experiment,
                                    const std::vector<double>& steps) {
  const auto reference = predict_one(model, experiment, on("featherstone", steps.back() / 32.0)).front();
  std::vector<double> out;
  for (const double step : steps) {
    out.push_back(worst_difference(predict_one(model, experiment, on("featherstone", step)).front()[0], reference[0]));
  }
  return out;
}

const Start kSwing{{1.2}, {0.0}};

Scenario swing(double period, const EffectSpec* friction = nullptr) {
  Scenario scenario = driven_scenario(
      pendulum(), {actuator("swing", "torque_source", {{"gain", 1.0}, {"damping", 0.2}, {"stiffness", 1.0}})},
      sine_drive(1, 4.0, period, 3.0), kSwing);
  if (friction != nullptr) scenario.effects.push_back(*friction);
  return scenario;
}

TEST(Rollout, IsOfFourthOrderInTheStepForSmoothMotion) {
  const Scenario scenario = swing(0.1);
  const auto e = errors_of_steps(PlantModel(scenario), started_experiment(scenario, kSwing), {0.1, 0.05, 0.025});
  for (std::size_t k = 0; k + 1 < e.size(); ++k) {
    // 2^4 = 16; the next order's share is still seen at these coarse steps.
    EXPECT_GT(e[k] / e[k + 1], 13.0) << "steps " << k;
    EXPECT_LT(e[k] / e[k + 1], 24.0) << "steps " << k;
  }
}

TEST(Rollout, StaysBetterThanSecondOrderThroughCoulombReversals) {
  const EffectSpec friction = effect("coulomb_friction", "swing", {{"Fc", 0.4}});
  const Scenario scenario = swing(0.1, &friction);
  const auto e =
      errors_of_steps(PlantModel(scenario), started_experiment(scenario, kSwing), {0.1, 0.05, 0.025, 0.0125});
  // Over three halvings: more than 2^(2*3) = 64. Single halvings jump with where in a step the reversals fall.
  EXPECT_GT(e.front() / e.back(), 64.0) << e[0] << " " << e[1] << " " << e[2] << " " << e[3];
  EXPECT_LT(e.back(), 1e-5);
}

TEST(Rollout, AgreesWithTheExactPeriodOfThePendulum) {
  // Rod on its end, q'' = -w^2 sin q with w^2 = (m g l/2) / (m l^2/3 + m w^2/12); T = 2 pi / (w agm(1, cos(q0/2))).
  const double q0 = 1.1, inertia = 0.0833667 + 0.25, omega = std::sqrt(9.81 * 0.5 / inertia);
  double a = 1.0, g = std::cos(0.5 * q0);
  for (int k = 0; k < 8; ++k) {
    const double next = 0.5 * (a + g);
    g = std::sqrt(a * g), a = next;
  }
  const double period = 2.0 * std::numbers::pi / (omega * a);
  const Start start{{q0}, {0.0}};
  const Scenario scenario =
      driven_scenario(pendulum(), {}, constant_drive(1, period * 3.0, period / 100.0, 0.0), start);
  for (const std::string& engine : available_engines()) {
    const auto p = predict_one(PlantModel(scenario), started_experiment(scenario, start), on(engine, 0.002)).front();
    // Fourth-order error of 0.002 s over three swings is 1e-9; ODE's acceleration is good to 1e-5 relative.
    const double tolerance = engine == "ode" ? 1e-4 : 1e-7;
    EXPECT_NEAR(p[0][300], q0, tolerance) << engine;
    EXPECT_NEAR(p[1][300], 0.0, 20.0 * tolerance) << engine;
    EXPECT_NEAR(p[0][50], -q0, tolerance) << engine;
  }
}

TEST(Rollout, HoldsCommandsBetweenSamples) {
  // A force of 1, -2, 3, ... N on the block, each for one sample: exact sums of parabolas.
  Drive drive = constant_drive(1, 1.0, 0.1, 0.0);
  for (std::size_t k = 0; k < drive.time.size(); ++k)
    drive.u[0][k] = (k % 2 == 0 ? 1.0 : -2.0) * static_cast<double>(k);
  const Start start{{0.0}, {0.5}};
  const Scenario scenario =
      driven_scenario(block_robot(), {actuator("slide", "direct_effort", {{"gain", 1.0}})}, drive, start);
  const auto p =
      predict_one(PlantModel(scenario), started_experiment(scenario, start), on("featherstone", 0.03)).front();
  double q = 0.0, v = 0.5;
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    ASSERT_NEAR(p[0][k], q, 1e-12) << "sample " << k;
    ASSERT_NEAR(p[1][k], v, 1e-12) << "sample " << k;
    const double a = drive.u[0][k] / kBlockMass;
    q += v * 0.1 + 0.5 * a * 0.01;
    v += a * 0.1;
  }
}

TEST(Rollout, DoesNotDependOnExtraSamplesWhereTheCommandStands) {
  const EffectSpec friction = effect("coulomb_friction", "swing", {{"Fc", 0.4}});
  const EffectSpec delay = effect("input_delay", "swing", {{"T", 0.013}});
  Drive sparse = sine_drive(1, 3.0, 0.1, 3.0), dense{{}, {{}}};
  std::vector<std::size_t> common;
  Noise random(3);
  for (std::size_t k = 0; k + 1 < sparse.time.size(); ++k) {
    common.push_back(dense.time.size());
    for (const double share : {0.0, 0.1 + 0.2 * random.uniform(), 0.5 + 0.4 * random.uniform()}) {
      dense.time.push_back(sparse.time[k] + share * 0.1);
      dense.u[0].push_back(sparse.u[0][k]);
    }
  }
  sparse.time.pop_back(), sparse.u[0].pop_back();
  auto run = [&](const Drive& drive) {
    Scenario scenario = driven_scenario(
        pendulum(), {actuator("swing", "torque_source", {{"gain", 1.0}, {"damping", 0.2}, {"stiffness", 1.0}})}, drive,
        kSwing);
    scenario.effects = {friction, delay};
    return predict_one(PlantModel(scenario), started_experiment(scenario, kSwing), on("featherstone", 0.001))
        .front()[0];
  };
  const auto a = run(sparse), b = run(dense);
  for (std::size_t k = 0; k < common.size(); ++k) {
    // Steps fall elsewhere: integration error at 1 ms, reversals included.
    ASSERT_NEAR(a[k], b[common[k]], 1e-8) << "t = " << sparse.time[k];
  }
}

/// A block whose valve sticks, lags and is late, driven through a whole recording.
Scenario late_block() {
  Scenario scenario = driven_scenario(
      block_robot(), {actuator("slide", "torque_source", {{"gain", 1.0}, {"damping", 2.0}, {"stiffness", 0.0}})},
      sine_drive(1, 6.0, 0.01, 5.0), {{0.0}, {0.0}});
  scenario.effects = {effect("input_delay", "slide", {{"T", 0.0437}}),
                      effect("valve_hysteresis", "slide", {{"h", 0.8}}), effect("actuator_lag", "slide", {{"T", 0.6}})};
  return scenario;
}

TEST(Rollout, AWindowRemembersTheCommandsBeforeIt) {
  Scenario scenario = late_block();
  const PlantModel model(scenario);
  const Start rest{{0.0}, {0.0}};
  for (const std::string& engine : {std::string("featherstone"), engine_of_data()}) {
    const auto whole = predict_one(model, started_experiment(scenario, rest), on(engine, 0.005)).front();
    scenario.prediction = Windows{1.0};
    Experiment cut = make_experiment(scenario);
    for (Segment& s : cut.segments)
      s.q0 = {whole[0][s.first]}, s.v0 = {whole[velocity_of(*scenario.robot, 0)][s.first]};
    const auto windows = predict_one(model, cut, on(engine, 0.005));
    ASSERT_EQ(windows.size(), 6u);
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const auto from = whole[0].begin() + static_cast<std::ptrdiff_t>(cut.segments[w].first);
      const std::vector<double> same(from, from + static_cast<std::ptrdiff_t>(windows[w][0].size()));
      EXPECT_LT(worst_difference(windows[w][0], same), 1e-9) << engine << ", window " << w;
    }
    scenario.prediction = FreeRun{};
  }
}

TEST(Rollout, AWindowBeginsAlikeInAnyCompany) {
  Scenario scenario = late_block();
  scenario.prediction = Windows{0.7};
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const auto together = predict_one(model, experiment, on("featherstone", 0.005));
  for (std::size_t w = 0; w < together.size(); ++w) {
    Experiment alone = experiment;
    alone.segments = {experiment.segments[w]};
    EXPECT_TRUE(same_bits(predict_one(model, alone, on("featherstone", 0.005)).front(), together[w])) << w;
  }
}

TEST(Rollout, UnderStiffFrictionIsAtRestExactlyAndWithoutChatterOnEveryEngine) {
  // The arm's joints under friction far above what drives them at times: it must stop, stay, and start again.
  auto robot = bundled_robot("double_pendulum/double_pendulum.urdf");
  const Start start{{0.5, 0.4}, {0.0, 0.0}};
  Drive drive = sine_drive(2, 4.0, 0.02, 60.0);
  for (std::size_t k = 0; k < drive.time.size(); ++k) {
    if (drive.time[k] > 2.0) drive.u[0][k] = drive.u[1][k] = 0.0;  // let go: friction holds it against gravity
  }
  Scenario scenario =
      driven_scenario(robot,
                      {actuator("shoulder", "torque_source", {{"gain", 1.0}, {"damping", 0.5}, {"stiffness", 2.0}}),
                       actuator("elbow", "torque_source", {{"gain", 1.0}, {"damping", 0.5}, {"stiffness", 2.0}})},
                      drive, start);
  scenario.effects = {effect("coulomb_friction", "shoulder", {{"Fc", 18.0}}),
                      effect("stribeck_friction", "elbow", {{"Fc", 8.0}, {"Fs", 12.0}, {"vs", 0.05}})};
  scenario.noise[ChannelKind::position] = {{"shoulder", 1e-3}, {"elbow", 1e-3}};
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, start);
  const StepChoice choice = choose_step(model, experiment, on("featherstone", 0.01), model.values());
  EXPECT_GE(choice.step, 3e-4) << "friction's stiffness must not force the step down";
  for (const std::string& engine : available_engines()) {
    const auto p = predict_one(model, experiment, on(engine, choice.step)).front();
    double fastest = 0.0;
    for (int j = 0; j < 2; ++j) {
      const auto& v = p[velocity_of(*robot, j)];
      for (std::size_t k = 0; k < v.size(); ++k) {
        ASSERT_TRUE(std::isfinite(v[k])) << engine;
        fastest = std::max(fastest, std::fabs(v[k]));
        if (drive.time[k] > 3.5) {
          ASSERT_EQ(v[k], 0.0) << engine << " joint " << j << " t = " << drive.time[k];
        }
      }
    }
    EXPECT_GT(fastest, 0.1) << engine << ": nothing moved, so nothing was tested";
  }
}

TEST(Rollout, StickSlipKeepsTheSpeedSigned) {
  // A drag spring pulled at constant speed over Stribeck friction: slides, sticks, never backwards.
  Drive drive = constant_drive(1, 6.0, 0.01, 0.0);
  for (std::size_t k = 0; k < drive.time.size(); ++k) drive.u[0][k] = drive.time[k];
  const Start start{{0.0}, {0.0}};
  Scenario scenario = driven_scenario(
      block_robot(), {actuator("slide", "torque_source", {{"gain", 20.0}, {"damping", 0.0}, {"stiffness", 200.0}})},
      drive, start);
  scenario.effects = {effect("stribeck_friction", "slide", {{"Fc", 4.0}, {"Fs", 9.0}, {"vs", 0.02}})};
  const auto p =
      predict_one(PlantModel(scenario), started_experiment(scenario, start), on("featherstone", 0.002)).front();
  int rests = 0, starts = 0;
  for (std::size_t k = 1; k < p[1].size(); ++k) {
    ASSERT_GE(p[1][k], 0.0) << "t = " << drive.time[k];
    rests += p[1][k] == 0.0;
    starts += p[1][k] > 0.0 && p[1][k - 1] == 0.0;
  }
  EXPECT_GT(rests, 100);
  EXPECT_GE(starts, 3);  // a spring of 200 N/m drawn at .1 m/s breaks away about every .5 s
}

}  // namespace
}  // namespace lacuna
