// The six-joint arm on hydraulic actuators: against an independent integrator, on every engine, in any company.
#include <gtest/gtest.h>

#include "physics/quantity.h"
#include "tests/physics/hydraulic_plants.h"

namespace lacuna {
namespace {

using namespace test;
using namespace test::hydraulic;

Numbers arm_joint(const Numbers& own) {
  const double dead = own.at("dead");
  Numbers out{{"full_command", 10.0},          {"dead_volume_a", dead},
              {"dead_volume_b", dead},         {"hose_compliance", 1 / 1.5e8},
              {"supply_pressure", 160 * kBar}, {"return_pressure", 5 * kBar},
              {"relief_pressure", 200 * kBar}, {"leakage", 5e-14}};
  for (const auto& [name, value] : own)
    if (name != "dead") out[name] = value;
  return out;
}
Numbers rotary(double gain, double displacement, double dead, double range) {
  return arm_joint(
      {{"gain", gain}, {"area_a", displacement}, {"area_b", displacement}, {"dead", dead}, {"stroke", range}});
}
Numbers on_lever(double gain, double bore, double rod, double dead, double stroke, const Numbers& lever) {
  const double quarter = std::numbers::pi / 4.0;
  Numbers out = arm_joint({{"gain", gain},
                           {"area_a", quarter * bore * bore},
                           {"area_b", quarter * (bore * bore - rod * rod)},
                           {"dead", dead},
                           {"stroke", stroke}});
  return with(out, lever);
}
/// Six joints of plausible size: oil rings at 4 to 80 Hz, hardly damped at the wrist. `hoses`: share of their volume.
Scenario hydraulic_arm(const Drive& drive, const Start& start, double hoses = 1.0) {
  const std::vector<Numbers> joints = {
      rotary(5e-9, 40e-6, 25e-6 * hoses, 2.2),
      on_lever(5.7e-9, 0.040, 0.020, 28e-6 * hoses, 0.134,
               {{"lever_a", 0.30}, {"lever_b", 0.078}, {"lever_angle", 1.0472}, {"middle", 0.52}}),
      on_lever(4.3e-9, 0.032, 0.016, 25e-6 * hoses, 0.105,
               {{"lever_a", 0.24}, {"lever_b", 0.060}, {"lever_angle", 2.3562}, {"middle", -0.83}}),
      rotary(4.2e-9, 20e-6, 20e-6 * hoses, 5.0),
      on_lever(3.0e-9, 0.025, 0.012, 22e-6 * hoses, 0.068,
               {{"lever_a", 0.15}, {"lever_b", 0.040}, {"lever_angle", 1.4835}}),
      rotary(4.2e-9, 8e-6, 20e-6 * hoses, 20.0)};
  std::vector<ActuatorSpec> actuators;
  for (std::size_t j = 0; j < joints.size(); ++j)
    actuators.push_back(actuator("joint_" + std::to_string(j + 1), "hydraulic", joints[j]));
  return driven_scenario(bundled_robot("hydrolek/seed_table1.urdf"), actuators, drive, start);
}
const Start kArmStart{{0.2, 0.4, -0.8, 0.3, 0.2, 0.1}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, false};

/// Jumps every .2 to .8 s, a third of them to a closed valve.
Drive jumps(double seconds, double amplitude) {
  Drive out{clock(seconds, 0.01), {}};
  Noise random(5);
  for (int j = 0; j < 6; ++j) {
    std::vector<double> u;
    double now = 0.0;
    for (int left = 10; u.size() < out.time.size(); --left) {
      if (left == 0) {
        now = random.uniform() < 0.3 ? 0.0 : (now > 0.0 ? -1.0 : 1.0) * amplitude * random.uniform();
        left = 20 + static_cast<int>(60.0 * random.uniform());
      }
      u.push_back(now);
    }
    out.u.push_back(std::move(u));
  }
  return out;
}

TEST(HydraulicArm, MeetsAnIndependentIntegratorAtTheMechanicsOwnStep) {
  for (const bool jumping : {false, true}) {
    const Drive drive = jumping ? jumps(2.0, 6.0) : sine_drive(6, 2.0, 0.01, 8.0);
    const Scenario scenario = hydraulic_arm(drive, kArmStart);
    const PlantModel model(scenario);
    const Experiment experiment = started_experiment(scenario, kArmStart);
    const auto reference = reference_of(model, experiment);
    const auto moved = [&](double step) { return predict_one(model, experiment, on("featherstone", step)).front(); };
    EXPECT_LT(worst_of(moved(kStep), reference, 6), kTenthOfNoise) << jumping;
    // An eighth of the step leaves a thousandth: above third order.
    EXPECT_LT(worst_of(moved(6.25e-4), reference, 6), 2e-8) << jumping;
    for (std::size_t j = 0; j < 6; ++j) {
      const auto [low, high] = std::minmax_element(reference[j].begin(), reference[j].end());
      EXPECT_GT(*high - *low, 0.01) << "joint " << j + 1 << " hardly moves";
    }
  }
}

TEST(HydraulicArm, WithoutHosesIsFasterStillAndMeetsItToo) {
  const Scenario scenario = hydraulic_arm(sine_drive(6, 2.0, 0.01, 8.0), kArmStart, 0.05);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  EXPECT_LT(
      worst_of(predict_one(model, experiment, on("featherstone", kStep)).front(), reference_of(model, experiment), 6),
      kTenthOfNoise);
}

/// A light wrist turns a loss into a decay faster than the steps.
TEST(HydraulicArm, LossesOfItsJointsAskForNoShorterStep) {
  Scenario scenario = hydraulic_arm(jumps(2.0, 6.0), kArmStart);
  const std::vector<double> losses{200.0, 240.0, 84.0, 3.6, 9.2, 0.56};
  for (std::size_t j = 0; j < losses.size(); ++j)
    scenario.effects.push_back(effect("viscous_friction", "joint_" + std::to_string(j + 1), {{"D", losses[j]}}));
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  const auto reference = reference_of(model, experiment);
  for (const double step : {kStep, 2.0 * kStep})
    EXPECT_LT(worst_of(predict_one(model, experiment, on("featherstone", step)).front(), reference, 6), kTenthOfNoise)
        << step;
}

/// rms over the channels' samples of the worst channel.
double worst_rms(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b) {
  double worst = 0.0;
  for (std::size_t c = 0; c < a.size(); ++c) {
    double sum = 0.0;
    for (std::size_t k = 0; k < a[c].size(); ++k) sum += std::pow(a[c][k] - b[c][k], 2);
    worst = std::max(worst, std::sqrt(sum / static_cast<double>(a[c].size())));
  }
  return worst;
}

TEST(HydraulicArm, SticksAndSlidesAsTheIndependentIntegratorHasIt) {
  Scenario scenario = hydraulic_arm(jumps(2.0, 6.0), kArmStart);
  for (const Joint& joint : scenario.robot->joints())
    scenario.noise[ChannelKind::position][joint.name] = 10.0 * kTenthOfNoise;
  scenario.effects = {effect("coulomb_friction", "joint_2", {{"Fc", 60.0}}),
                      effect("coulomb_friction", "joint_3", {{"Fc", 30.0}})};
  const auto differ = [&](double step) {
    const PlantModel model(scenario);
    const Experiment experiment = started_experiment(scenario, kArmStart);
    if (step == 0.0) step = choose_step(model, experiment, on("featherstone", 0.01), model.values()).step;
    return worst_rms(predict_one(model, experiment, on("featherstone", step)).front(), reference_of(model, experiment));
  };
  EXPECT_LT(differ(kStep), kTenthOfNoise);
  // A wrist that sticks rings through several reversals in a step; which one holds it takes a shorter one to see.
  scenario.effects.push_back(effect("coulomb_friction", "joint_4", {{"Fc", 2.0}}));
  EXPECT_LT(differ(0.0), kTenthOfNoise);
}

TEST(HydraulicArm, IsTheSameOnEveryEngine) {
  const Scenario scenario = hydraulic_arm(jumps(1.0, 6.0), kArmStart);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  const auto ours = predict_one(model, experiment, on("featherstone", kStep)).front();
  for (const std::string& engine : available_engines()) {
    const auto other = predict_one(model, experiment, on(engine, kStep)).front();
    // ODE's accelerations are derived from a tiny step.
    EXPECT_LT(worst_of(other, ours, 6), engine == "ode" ? 1e-6 : 1e-9) << engine;
  }
}

TEST(HydraulicArm, HasTheSameBitsInAnyCompanyAndOnAnyNumberOfThreads) {
  const Scenario scenario = hydraulic_arm(jumps(0.5, 6.0), kArmStart);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  Noise random(3);
  std::vector<std::vector<double>> values(static_cast<std::size_t>(lane_info().width) + 3, model.values());
  for (auto& individual : values)
    for (double& x : individual) x *= 0.8 + 0.4 * random.uniform();
  values[1][model.find("joint_4.bulk_modulus")] *= 30.0;  // needs many more pieces
  const auto together = predict(model, experiment, values, on("featherstone", kStep));
  EXPECT_TRUE(same_bits(together, predict(model, experiment, values, on("featherstone", kStep, 2))));
  for (const std::size_t i : {std::size_t{0}, std::size_t{2}, values.size() - 1})
    EXPECT_TRUE(same_bits(predict(model, experiment, {values[i]}, on("featherstone", kStep))[0], together[i])) << i;
  for (std::size_t i = 0; i < values.size(); ++i) {
    auto scalar = make_engine_predictor("featherstone", model, experiment);
    const std::vector<LaneTask> one{{&values[i], &experiment.segments[0]}};
    std::vector<std::vector<std::vector<double>>> expected;
    scalar->predict(one, kStep, expected);
    EXPECT_LT(worst_of(together[i][0], expected[0], 6), 1e-9) << i;
  }
}

TEST(HydraulicArm, PressuresAreComparedOnlyWhereThereAreChambersAndMotionsAreSimulated) {
  Scenario scenario = measured_whole(hydraulic_arm(jumps(1.0, 6.0), kArmStart));
  scenario.actuators[1] = actuator("joint_2", "torque_source", {{"gain", 1.0}, {"damping", 1.0}, {"stiffness", 1.0}});
  scenario.noise[ChannelKind::pressure_a]["joint_1"] = 2e4;
  const auto compared = [](const Scenario& of) {
    std::map<ChannelKind, std::vector<int>> out;
    for (const Channel& channel : make_experiment(of).channels) out[channel.kind].push_back(channel.joint);
    return out;
  };
  const std::vector<int> all{0, 2, 3, 4, 5};
  EXPECT_EQ(compared(scenario)[ChannelKind::pressure_a], all);
  EXPECT_EQ(compared(scenario)[ChannelKind::pressure_b], all);
  for (const Channel& channel : make_experiment(scenario).channels) {
    if (channel.kind != ChannelKind::pressure_a) continue;
    EXPECT_EQ(channel.noise_stated, channel.joint == 0);
    if (channel.joint == 0) {
      EXPECT_EQ(channel.noise, 2e4);
    }
  }
  scenario.prediction = InverseDynamics{10.0};
  EXPECT_TRUE(compared(scenario)[ChannelKind::pressure_a].empty());
  EXPECT_EQ(compared(scenario)[ChannelKind::effort].size(), 6u);
}

TEST(HydraulicArm, PressuresAreThoseOfTheIndependentIntegrator) {
  Scenario scenario = measured_whole(hydraulic_arm(jumps(1.0, 6.0), kArmStart));
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, kArmStart);
  ASSERT_EQ(experiment.channels.size(), 24u);
  const auto moved = predict_one(model, experiment, on("featherstone", kStep)).front();
  const auto reference = reference_of(model, experiment);
  for (std::size_t c = 0; c < moved.size(); ++c) {
    if (quantity_of(experiment.channels[c].kind).predicted_by != PredictedBy::chambers) continue;
    EXPECT_EQ(experiment.channels[c].unit, "Pa");
    const auto [low, high] = std::minmax_element(reference[c].begin(), reference[c].end());
    EXPECT_GT(*high - *low, kBar);
    EXPECT_LT(worst_difference(moved[c], reference[c]), 0.02 * kBar) << "channel " << c;
  }
}

}  // namespace
}  // namespace lacuna
