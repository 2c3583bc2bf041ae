// Plain fits of random robots whose truth another engine and integrator made: does least squares arrive?
#pragma once

#include <algorithm>
#include <memory>

#include "ga/identify.h"
#include "physics/catalogue.h"
#include "physics/truth.h"
#include "tests/conformance/random_robot.h"
#include "tests/physics/plants.h"

namespace lacuna::test {

inline constexpr double kRobotNoise = 3e-4;  // rad, m
inline constexpr double kNominalFactor = 3.0;

/// A fit beside what the truth itself leaves.
struct RobotFit {
  int joints = 0;
  std::string prediction;
  double over_truth = 0.0;  ///< rms of the residual over the truth's
  bool arrived = false;
  std::string doubt;
  int at_bounds = 0;
  long evaluations = 0;
};

/// Actuators that swing each joint at .7 to 2 Hz with some .1 rad (m) a volt, gains of both signs where the catalogue
/// lets them be.
inline std::vector<ActuatorSpec> random_actuators(Random& random, const std::shared_ptr<const Robot>& robot,
                                                  const Drive& drive) {
  const bool both_signs = actuator_table()[find_actuator("torque_source")].parameters.front().lower < 0.0;
  std::vector<ActuatorSpec> unit;
  for (const Joint& joint : robot->joints())
    unit.push_back(actuator(joint.name, "torque_source", {{"gain", 1.0}, {"damping", 1.0}, {"stiffness", 1.0}}));
  const std::vector<double> zero(robot->joints().size(), 0.0);
  const Scenario still = driven_scenario(robot, unit, drive, {zero, zero, false});
  const PlantModel model(still);
  const Experiment experiment = make_experiment(still);
  for (std::size_t j = 0; j < unit.size(); ++j) {
    const double inertia = typical_size(Scale::inertia, model, experiment, static_cast<int>(j), model.values());
    const double omega = 2.0 * std::numbers::pi * random.uniform(0.7, 2.0);
    const double stiffness = inertia * omega * omega;
    const double sign = both_signs && random.uniform(0, 1) < 0.5 ? -1.0 : 1.0;
    unit[j].parameters = {{"gain", sign * stiffness * random.uniform(0.05, 0.15)},
                          {"damping", 2.0 * random.uniform(0.3, 1.2) * inertia * omega},
                          {"stiffness", stiffness},
                          {"rest", random.uniform(-0.3, 0.3)}};
  }
  return unit;
}

/// A recording of `truth`, at rest first, by Simbody where it is built in.
inline std::shared_ptr<const Recording> recording_by_truth(const Scenario& truth, const Drive& drive,
                                                           const std::string& file, std::uint64_t seed) {
  Scenario scenario = truth;
  const std::vector<double> zero(truth.robot->joints().size(), 0.0);
  const auto data = recording_of(*truth.robot, drive, {zero, zero, false}, file);
  add_recording(scenario, data);
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  TruthOptions options;
  options.engine = engine_of_data();
  const auto motion = simulate_truth(model, experiment.segments.front(), experiment.channels, model.values(), options);
  Noise noise(seed);
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    const std::string& joint = truth.robot->joints()[experiment.channels[c].joint].name;
    auto& column = data->columns[data->find("q_" + joint)];
    column = motion[c];
    for (double& x : column) x += kRobotNoise * noise();
  }
  return data;
}

/// The robot with other link masses: those of `factors` times its own.
inline std::shared_ptr<const Robot> with_masses(const std::vector<BodySpec>& bodies,
                                                const std::vector<double>& factors) {
  std::vector<BodySpec> out = bodies;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].inertial.mass *= factors[i];
    out[i].inertial.inertia *= factors[i];
  }
  return make_robot("random tree", out);
}

/// The truth's scenario with everything that is searched off by up to kNominalFactor, and the total mass known in half
/// of the draws.
inline Scenario nominal_of(Random& random, const Scenario& truth, const std::vector<BodySpec>& bodies) {
  const auto off = [&] { return std::exp(random.uniform(-1.0, 1.0) * std::log(kNominalFactor)); };
  Scenario out = truth;
  for (ActuatorSpec& spec : out.actuators)
    for (const char* name : {"gain", "damping", "stiffness"}) spec.parameters[name] *= off();
  std::vector<double> factors;
  double total = 0.0;
  for (const BodySpec& body : bodies) factors.push_back(off()), total += body.inertial.mass;
  out.robot = with_masses(bodies, factors);
  for (const char* name : {"gain", "damping", "stiffness", "mass"})
    out.identify.push_back({name, true, 0.25, 4.0, std::string("test: identify.") + name});
  if (random.uniform(0, 1) < 0.5) out.total_mass = total;
  out.noise[ChannelKind::position] = {};
  for (const Joint& joint : truth.robot->joints()) out.noise[ChannelKind::position][joint.name] = kRobotNoise;
  return out;
}

/// Draw `seed`: a tree of 2 to 7 joints, its recordings, its fit from wrong nominal values.
inline RobotFit fit_random_robot(std::uint64_t seed, Optimizer optimizer = Optimizer::lsq) {
  Random random(seed);
  RobotFit out;
  out.joints = 2 + random.below(6);
  const std::vector<BodySpec> bodies = random_bodies(random, out.joints);
  const auto robot = make_robot("random tree", bodies);
  const auto rested = [&](double shift) {
    Drive drive = sine_drive(out.joints, 8.0, 0.02, 3.0, shift);
    for (auto& u : drive.u) std::fill_n(u.begin(), 25, 0.0);
    return drive;
  };
  const Scenario truth = bare_scenario(robot, random_actuators(random, robot, rested(0.0)), false);
  Scenario scenario = nominal_of(random, truth, bodies);
  for (int k = 0; k < 2; ++k) {
    add_recording(scenario, recording_by_truth(truth, rested(7.3 * k), "train_" + std::to_string(k) + ".csv",
                                               10 * seed + static_cast<std::uint64_t>(k)));
  }
  const std::pair<const char*, Prediction> predictions[] = {
      {"free run", FreeRun{}}, {"windows", Windows{1.0}}, {"inverse dynamics", InverseDynamics{8.0}}};
  const auto& [name, prediction] = predictions[random.below(3)];
  out.prediction = name;
  scenario.prediction = prediction;
  const PlantModel model(scenario);
  const Experiment experiment = make_experiment(scenario);
  const SearchSpace space(model, scenario, Coordinates::ratios);
  IdentifyOptions options;
  options.optimizer = optimizer;
  options.genetic.seed = seed;
  options.simulator.threads = 1;
  const FitResult fit = identify(model, experiment, space, options);
  std::vector<double> true_values = fit.values;
  Scenario known = scenario;
  known.robot = robot, known.actuators = truth.actuators;
  true_values = PlantModel(known).values();
  SimulatorOptions simulator = options.simulator;
  simulator.max_step = fit.step.step;
  Problem problem(model, experiment, space, simulator, first_weights(model, experiment));
  const std::vector<std::vector<double>> one{true_values};
  const double left = problem.residuals_of(one, experiment.with_role(Role::train)).front().norm();
  out.over_truth = fit.solution.residual.norm() / left;
  out.arrived = fit.arrived, out.doubt = fit.doubt, out.evaluations = fit.evaluations;
  for (const Estimate& e : fit.estimates) out.at_bounds += e.at_bound ? 1 : 0;
  return out;
}

}  // namespace lacuna::test
