// The bundled hydraulic arm: its truth is found again, or leaves the noise alone; a source of torque does neither.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ga/problem.h"
#include "ga/start_effects.h"
#include "tests/ga/plant_problems.h"

namespace lacuna {
namespace {

using namespace test;

const std::filesystem::path kHydraulic =
    std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios" / "hydrolek" / "hydraulic";
constexpr double kPositionNoise = 3e-4, kPressureNoise = 1e4;  // rad, Pa, rms, in the bundled recordings

// Sanitized code is some thirty times slower: the same paths over fewer seconds.
#if defined(__SANITIZE_ADDRESS__)
constexpr double kSpan = 3.0;
#else
constexpr double kSpan = 20.0;
#endif

Scenario hydraulic_scenario(const std::string& file, bool recordings) {
  Scenario out = load_scenario(kHydraulic / file, {.load_recordings = recordings});
  for (RecordingSpec& recording : out.recordings) recording.to = kSpan;
  return out;
}

FitResult least_squares_fit(const Scenario& scenario) {
  const PlantModel model(scenario);
  IdentifyOptions options;
  options.optimizer = Optimizer::lsq;
  options.simulator.threads = 2;
  options.step = 0.01;
  options.start_errors = true;
  return identify(model, make_experiment(scenario), SearchSpace(model, scenario), options);
}
double rms_in(const FitResult& fit, Role role, const std::string& channel) {
  for (const auto& [of, entries] : fit.rms)
    for (const auto& [name, rms] : entries)
      if (of == role && name == channel) return rms;
  return std::nan("");
}

TEST(HydraulicRecovery, FindsValveFrictionAndLeakageOfJoint2FromItsAngleAndPressures) {
  const Scenario scenario = hydraulic_scenario("joint_2/hydraulic.yaml", true);
  const FitResult fit = least_squares_fit(scenario);
  const PlantModel model(scenario), truth(hydraulic_scenario("joint_2/truth.yaml", false));
  for (const std::string name : {"joint_2.gain", "joint_2.viscous_friction.D", "joint_2.leakage"}) {
    const double found = fit.values[model.find(name)];
    const double planted = truth.values()[truth.find(name)];
    EXPECT_NEAR(found, planted, 0.01 * planted) << name;
  }
  // Three standard errors of an rms of so many samples, and what the integration may add.
  const double most = 1.05 + 3.0 / std::sqrt(2.0 * kSpan / 0.01);
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    EXPECT_LT(rms_in(fit, role, "joint_2"), most * kPositionNoise) << to_string(role);
    EXPECT_LT(rms_in(fit, role, "joint_2.pressure_a"), most * kPressureNoise) << to_string(role);
    EXPECT_LT(rms_in(fit, role, "joint_2.pressure_b"), most * kPressureNoise) << to_string(role);
  }
}

TEST(HydraulicRecovery, NineNumbersOfATorqueSourceDoNotPredictTheSameJoint) {
  EXPECT_GT(
      rms_in(least_squares_fit(hydraulic_scenario("joint_2/torque_source.yaml", true)), Role::validate, "joint_2"),
      10.0 * kPositionNoise);
}

/// Chi-square of what the bundled arm's truth leaves of all recordings, with the errors of the starts taken off.
void expect_noise_alone(const Prediction& prediction) {
  const Scenario given = hydraulic_scenario("scenario.yaml", true);
  Scenario truth = hydraulic_scenario("truth.yaml", false);
  truth.recordings = given.recordings;
  truth.prediction = prediction;
  for (const Joint& joint : truth.robot->joints()) {
    truth.noise[ChannelKind::position][joint.name] = (joint.prismatic() ? 0.1 : 1.0) * kPositionNoise;
    truth.noise[ChannelKind::pressure_a][joint.name] = truth.noise[ChannelKind::pressure_b][joint.name] =
        kPressureNoise;
  }
  const PlantModel model(truth);
  Experiment experiment = make_experiment(truth);
  SimulatorOptions options = on("featherstone", 0.01, 2);
  options.max_step = choose_step(model, experiment, options, model.values()).step;
  // One noisy sample each is where the pressures start: what that does to all the rest is known, and is taken off.
  ASSERT_TRUE(attach_start_effects(experiment, model, options, model.values()));
  std::vector<double> noise;
  for (const Channel& channel : experiment.channels) noise.push_back(channel.noise);
  Problem problem(model, experiment, SearchSpace(model, truth), options, noise);
  std::vector<int> all;
  for (std::size_t s = 0; s < experiment.segments.size(); ++s) all.push_back(static_cast<int>(s));
  const Eigen::VectorXd r = problem.residuals_of(std::vector<std::vector<double>>{model.values()}, all).front();
  const double samples = static_cast<double>(r.size());
  // Chi-square, three standard deviations; integration at a tenth of the noise may add a hundredth of its energy.
  const double scatter = 3.0 * std::sqrt(2.0 * samples);
  EXPECT_LT(r.squaredNorm(), 1.01 * samples + scatter);
  EXPECT_GT(r.squaredNorm(), samples - scatter - 4.0 * static_cast<double>(experiment.channels.size() * all.size()));
}

TEST(HydraulicRecovery, TheTruthOfAllJointsLeavesTheNoiseAloneInFreeRuns) { expect_noise_alone(FreeRun{}); }

TEST(HydraulicRecovery, TheTruthOfAllJointsLeavesTheNoiseAloneInWindows) { expect_noise_alone(Windows{2.0}); }

}  // namespace
}  // namespace lacuna
