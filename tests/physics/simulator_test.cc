// The population call: lanes, threads and engines give the same answer; the step follows the noise.
#include <gtest/gtest.h>

#include <mutex>
#include <tuple>

#include "tests/physics/plants.h"

namespace lacuna {
namespace {

using namespace test;

const Start kArmStart{{0.0, 0.4, -0.3, 0.2, 0.3, 0.0}, std::vector<double>(6, 0.0), false};

/// Six joints on damped springs, like the seed's arm.
Scenario arm(const Drive& drive) {
  auto robot = bundled_robot("hydrolek/seed_table1.urdf");
  const double gain[6] = {100.0, 170.0, 70.0, 3.0, 8.0, 1.5};
  const double damping[6] = {200.0, 240.0, 84.0, 3.6, 9.2, 0.56};
  const double stiffness[6] = {1500.0, 3800.0, 960.0, 46.0, 84.0, 7.8};
  std::vector<ActuatorSpec> drives;
  for (std::size_t j = 0; j < 6; ++j) {
    drives.push_back(
        actuator(robot->joints()[j].name, "torque_source",
                 {{"gain", gain[j]}, {"damping", damping[j]}, {"stiffness", stiffness[j]}, {"rest", kArmStart.q[j]}}));
  }
  return driven_scenario(robot, drives, drive, kArmStart);
}

/// Parameter vectors around the model's own: factors from 0.8 to 1.2 on everything that is not zero or infinite.
std::vector<std::vector<double>> population(const PlantModel& model, int count, std::uint64_t seed) {
  Noise random(seed);
  std::vector<std::vector<double>> out;
  for (int i = 0; i < count; ++i) {
    out.push_back(model.values());
    for (double& x : out.back()) {
      if (std::isfinite(x)) x *= 0.8 + 0.4 * random.uniform();
    }
  }
  return out;
}

TEST(Lanes, EqualTheScalarPathToRoundingOverTwentySeconds) {
  constexpr double kRelative = 1e-12;
  const Scenario scenario = arm(sine_drive(6, 20.0, 0.01, 4.0));
  const PlantModel model = PlantModel(scenario).with_effects(
      {effect("valve_offset", "joint_3", {{"b", 0.2}}), effect("actuator_saturation", "joint_2", {{"cap", 3.0}})});
  const Experiment experiment = started_experiment(scenario, kArmStart);
  const auto values = population(model, lane_info().width + 1, 5);
  const auto lanes = predict(model, experiment, values, on("featherstone", 0.005));
  auto scalar = make_engine_predictor("featherstone", model, experiment);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::vector<LaneTask> one{{&values[i], &experiment.segments[0]}};
    std::vector<std::vector<std::vector<double>>> expected;
    scalar->predict(one, 0.005, expected);
    for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
      double size = 0.0;
      for (const double x : expected[0][c]) size = std::max(size, std::fabs(x));
      EXPECT_LT(worst_difference(lanes[i][0][c], expected[0][c]), kRelative * size)
          << "individual " << i << " channel " << c;
    }
  }
}

TEST(Lanes, DoNotDisturbEachOtherWhenOneDivergesOrHoldsGarbage) {
  const Scenario scenario = arm(sine_drive(6, 1.0, 0.01, 4.0));
  const PlantModel model = PlantModel(scenario).with_effects({effect("coulomb_friction", "joint_2", {{"Fc", 30.0}})});
  const Experiment experiment = started_experiment(scenario, kArmStart);
  auto values = population(model, lane_info().width, 6);
  const auto clean = predict(model, experiment, values, on("featherstone", 0.005));
  for (const double bad : {kMissing, HUGE_VAL, 1e300, -1e9}) {
    auto spoilt = values;
    spoilt[1][model.find("joint_2.gain")] = bad;
    const auto out = predict(model, experiment, spoilt, on("featherstone", 0.005));
    EXPECT_FALSE(same_bits(out[1], clean[1]));
    if (!std::isfinite(bad)) {
      EXPECT_FALSE(std::isfinite(out[1][0][1].back())) << bad;  // it shows as failed
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i == 1) continue;
      EXPECT_TRUE(same_bits(out[i], clean[i])) << "lane " << i << " beside a gain of " << bad;
    }
  }
}

TEST(Lanes, GiveTheSameAnswerInWhateverCompanyAnIndividualIsSimulated) {
  const Scenario scenario = arm(sine_drive(6, 1.0, 0.01, 4.0));
  const PlantModel model = PlantModel(scenario).with_effects(
      {effect("coulomb_friction", "joint_2", {{"Fc", 30.0}}), effect("input_delay", "joint_3", {{"T", 0.013}})});
  const Experiment experiment = started_experiment(scenario, kArmStart);
  const auto values = population(model, 2 * lane_info().width + 3, 7);
  const auto together = predict(model, experiment, values, on("featherstone", 0.005));
  for (const std::size_t i : {std::size_t{0}, std::size_t{3}, values.size() - 1}) {
    EXPECT_TRUE(same_bits(predict(model, experiment, {values[i]}, on("featherstone", 0.005))[0], together[i])) << i;
  }
}

TEST(Lanes, GiveTheSameAnswerWhicheverSegmentsShareThem) {
  // Each recording has commands, start, time in the session and friction of its own; one is shorter, one on a clock of
  // its own.
  Scenario scenario = arm(sine_drive(6, 1.0, 0.01, 4.0));
  using Row = std::tuple<double, double, const char*>;
  for (const auto& [seconds, period, file] : {Row{1.0, 0.01, "b.csv"}, {1.02, 0.0102, "c.csv"}, {0.7, 0.01, "d.csv"}}) {
    const Drive drive = sine_drive(6, seconds, period, 4.0, 2.0 * file[0]);
    add_recording(scenario, recording_of(*scenario.robot, drive, kArmStart, file));
  }
  EffectSpec friction = effect("coulomb_friction", "joint_2", {{"Fc", 30.0}});
  friction.recordings = {"b.csv"};
  const PlantModel model = PlantModel(scenario).with_effects(
      {friction, effect("input_delay", "joint_3", {{"T", 0.013}}), effect("sensor_delay", "joint_5", {{"T", 0.017}}),
       effect("thermal_drift", "joint_1", {{"depth", 0.3}, {"tau", 2.0}})});
  Experiment experiment = started_experiment(scenario, kArmStart);
  double shift = 0.0;
  for (Segment& segment : experiment.segments) segment.q0[0] += 0.1 * shift, segment.v0[2] = -0.2 * shift++;
  const auto values = population(model, lane_info().width + 3, 9);
  const Predictions together = predict(model, experiment, values, on("featherstone", 0.005, 2));
  for (int s = 0; s < 4; ++s) {
    const std::vector<int> one{s};
    make_simulator(model, experiment, on("featherstone", 0.005))->run(values, one, [&](int i, int, const auto& alone) {
      EXPECT_TRUE(same_bits(alone, together[i][s])) << i << ' ' << s;
    });
  }
  EXPECT_FALSE(same_bits(together[0][0], together[0][2]));
}

TEST(Simulator, GivesTheSameBitsOnOneAndTwoThreadsOnEveryEngine) {
  Scenario scenario = arm(sine_drive(6, 1.0, 0.01, 4.0));
  scenario.prediction = Windows{0.2};
  const PlantModel model = PlantModel(scenario).with_effects({effect("coulomb_friction", "joint_2", {{"Fc", 30.0}})});
  const Experiment experiment = make_experiment(scenario);
  const auto values = population(model, 5, 8);
  for (const std::string& engine : available_engines()) {
    EXPECT_TRUE(same_bits(predict(model, experiment, values, on(engine, 0.005, 1)),
                          predict(model, experiment, values, on(engine, 0.005, 2))))
        << engine;
  }
}

TEST(Simulator, VisitsEveryPairOfIndividualAndSegmentOnce) {
  Scenario scenario = arm(sine_drive(6, 1.0, 0.01, 4.0));
  scenario.prediction = Windows{0.25};
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  ASSERT_EQ(experiment.segments.size(), 4u);
  const auto values = population(model, lane_info().width + 2, 9);
  std::mutex lock;
  std::map<std::pair<int, int>, int> seen;
  const std::vector<int> asked{3, 1};
  make_simulator(model, experiment, on("featherstone", 0.01, 2))
      ->run(values, asked, [&](int i, int s, const auto& predicted) {
        const std::lock_guard<std::mutex> hold(lock);
        ++seen[{i, s}];
        EXPECT_EQ(predicted.size(), experiment.channels.size());
      });
  EXPECT_EQ(seen.size(), 2 * values.size());
  for (const auto& [pair, times] : seen) {
    EXPECT_EQ(times, 1);
    EXPECT_TRUE(pair.second == 1 || pair.second == 3);
  }
}

TEST(Simulator, EnginesAgreeOnOneRolloutWithDelaySaturationPayloadAndFriction) {
  constexpr double kAgreement = 1e-8;  // rad, over 2 s
  constexpr double kRubbing = 1e-8;    // rad: events of friction are located, so they amplify rounding no further
  constexpr double kOde = 1e-4;        // rad: its accelerations are good to 1e-5 of theirs, integrated over 2 s
  const Scenario scenario = arm(sine_drive(6, 2.0, 0.01, 5.0));
  const PlantModel smooth = PlantModel(scenario).with_effects({effect("input_delay", "joint_3", {{"T", 0.023}}),
                                                               effect("actuator_saturation", "joint_2", {{"cap", 3.0}}),
                                                               effect("payload", "arm", {{"m", 3.0}})});
  const PlantModel rubbing = smooth.with_effects({effect("coulomb_friction", "joint_2", {{"Fc", 40.0}})});
  const Experiment experiment = started_experiment(scenario, kArmStart);
  const auto reference = predict_one(smooth, experiment, on("featherstone", 0.005)).front();
  const auto rubbed = predict_one(rubbing, experiment, on("featherstone", 0.005)).front();
  for (const std::string& engine : available_engines()) {
    const auto other = predict_one(smooth, experiment, on(engine, 0.005)).front();
    const auto other_rubbed = predict_one(rubbing, experiment, on(engine, 0.005)).front();
    for (std::size_t c = 0; c < reference.size(); ++c) {
      EXPECT_LT(worst_difference(other[c], reference[c]), engine == "ode" ? kOde : kAgreement)
          << engine << " joint " << c;
      EXPECT_LT(worst_difference(other_rubbed[c], rubbed[c]), kRubbing) << engine << " joint " << c;
    }
  }
}

TEST(Simulator, RefusesAnUnknownEngine) {
  const Scenario scenario = arm(constant_drive(6, 0.2, 0.01, 0.0));
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  EXPECT_THROW(make_simulator(model, experiment, on("imaginary", 0.01)), InputError);
}

TEST(Simulator, StopsWhenItIsAskedTo) {
  const Scenario scenario = arm(constant_drive(6, 0.2, 0.01, 0.0));
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  StopFlag stop{true};
  SimulatorOptions options = on("featherstone", 0.01);
  options.stop = &stop;
  EXPECT_THROW(predict_one(model, experiment, options), Interrupted);
}

/// Largest rms of a difference over the channels, over the noise.
double error_over(double noise, const std::vector<std::vector<double>>& some,
                  const std::vector<std::vector<double>>& truth) {
  double worst = 0.0;
  for (std::size_t c = 0; c < some.size(); ++c) {
    double sum = 0.0;
    for (std::size_t k = 0; k < some[c].size(); ++k) sum += std::pow(some[c][k] - truth[c][k], 2);
    const double error = std::sqrt(sum / static_cast<double>(some[c].size())) / noise;
    worst = std::isfinite(error) ? std::max(worst, error) : HUGE_VAL;
  }
  return worst;
}

TEST(ChooseStep, KeepsTheIntegrationErrorUnderATenthOfTheNoise) {
  for (const double noise : {1e-3, 1e-6, 1e-10}) {
    Scenario scenario = arm(sine_drive(6, 2.0, 0.01, 5.0));
    for (const Joint& joint : scenario.robot->joints()) scenario.noise[ChannelKind::position][joint.name] = noise;
    const PlantModel model = PlantModel(scenario).with_effects({effect("coulomb_friction", "joint_2", {{"Fc", 40.0}})});
    const Experiment experiment = started_experiment(scenario, kArmStart);
    const StepChoice choice = choose_step(model, experiment, on("featherstone", 0.01), model.values());
    if (noise == 1e-10) {
      // Out of reach through reversals: the shortest step, and an honest figure.
      EXPECT_GT(choice.error_over_noise, 0.1);
      EXPECT_LT(choice.step, 2e-4);
      continue;
    }
    const auto chosen = predict_one(model, experiment, on("featherstone", choice.step)).front();
    const auto truth = predict_one(model, experiment, on("featherstone", choice.step / 16.0)).front();
    EXPECT_LT(error_over(noise, chosen, truth), 0.1) << "noise " << noise << " step " << choice.step;
    EXPECT_LT(choice.error_over_noise, 0.1);
  }
}

TEST(ChooseStep, IsTheLongestWholePartOfASampleThatKeepsToTheRule) {
  std::set<int> seen;
  for (double noise = 3e-4; noise > 1e-8; noise *= 0.4) {
    Scenario scenario = arm(sine_drive(6, 2.0, 0.01, 3.0));
    for (const Joint& joint : scenario.robot->joints()) scenario.noise[ChannelKind::position][joint.name] = noise;
    const PlantModel model(scenario);
    const Experiment experiment = started_experiment(scenario, kArmStart);
    const StepChoice choice = choose_step(model, experiment, on("featherstone", 0.01), model.values());
    const int parts = static_cast<int>(std::lround(0.01 / choice.step));
    EXPECT_DOUBLE_EQ(choice.step, 0.01 / parts);
    const auto at = [&](int n) { return predict_one(model, experiment, on("featherstone", 0.01 / n)).front(); };
    const auto truth = at(16 * parts);
    EXPECT_LT(error_over(noise, at(parts), truth), 0.1) << noise << ", " << parts << " steps a sample";
    EXPECT_NEAR(error_over(noise, at(parts), truth), choice.error_over_noise, 0.2 * choice.error_over_noise);
    // The estimate is of fourth order, the error has others beside it.
    const double longer = parts > 1 ? error_over(noise, at(parts - 1), truth) : HUGE_VAL;
    EXPECT_FALSE(longer < 0.08) << noise << ", " << parts << ": " << longer;
    seen.insert(parts);
  }
  EXPECT_TRUE(seen.count(3) > 0 || seen.count(5) > 0 || seen.count(7) > 0) << "only powers of two";
}

TEST(ChooseStep, TakesNoShortStepsForWhatDivergesAtAnyStep) {
  Scenario scenario = arm(constant_drive(6, 0.2, 0.01, 10.0));
  for (const Joint& joint : scenario.robot->joints()) scenario.noise[ChannelKind::position][joint.name] = 1e-3;
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  std::vector<double> values = model.values();
  values[model.find("joint_2.damping")] = -1e6;
  const StepChoice choice = choose_step(model, experiment, on("featherstone", 0.01), values);
  EXPECT_EQ(choice.step, 0.01);
  EXPECT_FALSE(std::isfinite(choice.error_over_noise));
}

/// Positions of the double pendulum recorded at 1 kHz.
Scenario smooth_recording(double damping) {
  auto robot = bundled_robot("double_pendulum/double_pendulum.urdf");
  Scenario scenario =
      bare_scenario(robot,
                    {actuator("shoulder", "torque_source", {{"gain", 3.0}, {"damping", 1.5}, {"stiffness", 20.0}}),
                     actuator("elbow", "torque_source", {{"gain", 2.0}, {"damping", damping}, {"stiffness", 10.0}})},
                    false);
  return scenario;
}

TEST(InverseDynamicsPrediction, LeavesNothingOfDataThatTheSameModelMade) {
  // What is left is the filter's action on products of signals, on the start and on the held command, at 40 Hz.
  constexpr double kShare = 1e-2;  // of the command's rms
  Scenario scenario = smooth_recording(0.8);
  const Drive drive = sine_drive(2, 4.0, 0.001, 3.0);
  add_recording(scenario,
                simulated_recording(scenario, drive, {{0.1, 0.2}, {0.0, 0.0}, false}, "featherstone", "run.csv"));
  scenario.prediction = InverseDynamics{40.0};
  const PlantModel same(scenario);
  const Experiment experiment = make_experiment(scenario);
  Scenario wrong_scenario = smooth_recording(1.6);
  const PlantModel wrong(wrong_scenario);
  auto rms = [](const std::vector<double>& x) {
    double sum = 0.0;
    for (const double y : x) sum += y * y;
    return std::sqrt(sum / static_cast<double>(x.size()));
  };
  const auto left_by = [&](const PlantModel& model) {
    auto out = predict_one(model, experiment, on("featherstone", 0.01)).front();
    for (std::size_t c = 0; c < out.size(); ++c)
      for (std::size_t k = 0; k < out[c].size(); ++k) out[c][k] -= experiment.segments[0].measured[c][k];
    return out;
  };
  const auto residual = left_by(same), off = left_by(wrong);
  ASSERT_EQ(residual.size(), 2u);
  for (std::size_t j = 0; j < 2; ++j) EXPECT_LT(rms(residual[j]), kShare * experiment.command_rms[j]) << "joint " << j;
  EXPECT_GT(rms(off[1]), 5.0 * kShare * experiment.command_rms[1]) << "a wrong damping must show";
}

TEST(InverseDynamicsPrediction, IsTheSameOnEveryEngine) {
  Scenario scenario = smooth_recording(0.8);
  const Drive drive = sine_drive(2, 1.0, 0.001, 3.0);
  add_recording(scenario,
                simulated_recording(scenario, drive, {{0.1, 0.2}, {0.0, 0.0}, false}, "featherstone", "run.csv"));
  scenario.prediction = InverseDynamics{40.0};
  const PlantModel model = PlantModel(scenario).with_effects({effect("coulomb_friction", "elbow", {{"Fc", 0.3}})});
  const Experiment experiment = make_experiment(scenario);
  const auto reference = predict_one(model, experiment, on("featherstone", 0.01)).front();
  for (const std::string& engine : available_engines()) {
    const auto other = predict_one(model, experiment, on(engine, 0.01)).front();
    for (std::size_t j = 0; j < 2; ++j) {
      // V, of efforts of some 10 N m over gains of 2 to 3: ODE's relative 1e-5, rounding for the others.
      EXPECT_LT(worst_difference(other[j], reference[j]), engine == "ode" ? 1e-3 : 1e-9) << engine;
    }
  }
}

}  // namespace
}  // namespace lacuna
