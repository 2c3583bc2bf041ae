// The bundled hydraulic arm: its truth is found again, or leaves the noise alone; a source of torque does neither.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
    const double found = fit.values[static_cast<std::size_t>(model.find(name))];
    const double planted = truth.values()[static_cast<std::size_t>(truth.find(name))];
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

TEST(HydraulicRecovery, TheTruthOfAllJointsLeavesTheNoiseAlone) {
  const Scenario given = hydraulic_scenario("scenario.yaml", true);
  Scenario truth = hydraulic_scenario("truth.yaml", false);
  truth.recordings = given.recordings;
  std::erase_if(truth.recordings, [](const RecordingSpec& r) { return r.role != Role::test; });
  truth.prediction = given.prediction;
  const PlantModel model(truth);
  const Experiment experiment = make_experiment(truth);
  std::vector<double> squares(experiment.channels.size(), 0.0);
  double samples = 0.0;
  const auto predicted = predict_one(model, experiment, on("featherstone", 0.005));
  for (std::size_t s = 0; s < predicted.size(); ++s) {
    samples += static_cast<double>(experiment.segments[s].count);
    for (std::size_t c = 0; c < squares.size(); ++c)
      for (std::size_t k = 0; k < predicted[s][c].size(); ++k)
        squares[c] += std::pow(predicted[s][c][k] - experiment.segments[s].measured[c][k], 2);
  }
  // The noise of the starts adds no more than its own energy.
  for (std::size_t c = 0; c < squares.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const bool slides = channel.joint == 6;
    const double noise = channel.kind != ChannelKind::position ? kPressureNoise
                         : slides                              ? 0.1 * kPositionNoise
                                                               : kPositionNoise;
    EXPECT_LT(std::sqrt(squares[c] / samples), std::sqrt(2.0) * noise)
        << experiment.joint_names[static_cast<std::size_t>(channel.joint)] << " " << to_string(channel.kind);
  }
}

}  // namespace
}  // namespace lacuna
