// Identification problems with known answers: a pendulum and the block, simulated in memory.
#pragma once

#include "ga/identify.h"
#include "tests/physics/plants.h"

namespace lacuna::test {

/// A driven pendulum on a damped spring; `truth` puts its parameters in.
struct PendulumTruth {
  double gain = 3.0, damping = 0.8, stiffness = 4.0, mass = 1.0;
};

inline Scenario pendulum_scenario(const PendulumTruth& p) {
  Scenario scenario = bare_scenario(
      bundled_robot("pendulum/pendulum.urdf"),
      {actuator("swing", "torque_source", {{"gain", p.gain}, {"damping", p.damping}, {"stiffness", p.stiffness}})},
      false);
  return scenario;
}

/// Sines after half a second at rest: from a start in mid-motion the speed is known only as well as noise allows.
inline Drive rested_drive(double seconds, double shift, int joints = 1) {
  Drive drive = sine_drive(joints, seconds, 0.02, 3.0, shift);
  for (std::vector<double>& u : drive.u) std::fill_n(u.begin(), 25, 0.0);
  return drive;
}

/// `model` driven as the recordings of `truth` were, with bounds 0.2 to 5 times its values on `free`.
inline Scenario pendulum_problem(const PendulumTruth& start, const std::vector<std::string>& free, double noise,
                                 std::vector<EffectSpec> concealed = {}, double seconds = 6.0,
                                 const std::string& engine = "featherstone") {
  Scenario truth = pendulum_scenario({});
  truth.effects = std::move(concealed);
  Scenario scenario = pendulum_scenario(start);
  const Start rest{{0.0}, {0.0}, false};
  int k = 0;
  for (const Role role : {Role::train, Role::validate, Role::test}) {
    const std::string file = std::string(to_string(role)) + ".csv";
    add_recording(scenario,
                  simulated_recording(truth, rested_drive(seconds, 7.3 * k), rest, engine, file, noise,
                                      static_cast<std::uint64_t>(k) + 11),
                  role);
    ++k;
  }
  for (const std::string& name : free) scenario.identify.push_back({name, true, 0.2, 5.0, "test: identify." + name});
  // What a transducer resolves: noise-free data need a level to weigh by.
  scenario.noise[ChannelKind::position]["swing"] = std::max(noise, 1e-6);
  return scenario;
}

/// A block on a slide (m) and a pendulum (rad) on one base: neither moves the other. Its recordings have `concealed`.
inline Scenario two_machines(std::vector<EffectSpec> concealed = {}, const std::vector<Role>& roles = {Role::train},
                             double noise = 1e-5) {
  const auto robot = Robot::from_urdf_text(R"(<robot name='two'><link name='ground'/>
  <link name='block'><inertial><mass value='2'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <link name='rod'><inertial><origin xyz='0 0 -0.5'/><mass value='1'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='slide' type='prismatic'><parent link='ground'/><child link='block'/><axis xyz='1 0 0'/>
  <limit lower='-100' upper='100' effort='1e9' velocity='1e9'/></joint>
  <joint name='swing' type='revolute'><parent link='ground'/><child link='rod'/><axis xyz='0 1 0'/>
  <limit lower='-100' upper='100' effort='1e9' velocity='1e9'/></joint></robot>)",
                                           "two");
  Scenario scenario =
      bare_scenario(robot,
                    {actuator("slide", "torque_source", {{"gain", 3.0}, {"damping", 4.0}, {"stiffness", 20.0}}),
                     actuator("swing", "torque_source", {{"gain", 3.0}, {"damping", 0.8}, {"stiffness", 4.0}})},
                    false);
  Scenario truth = scenario;
  truth.effects = std::move(concealed);
  int k = 0;
  for (const Role role : roles) {
    const Drive drive = rested_drive(8.0, 7.3 * k, 2);
    const std::string file = k == 0 ? "run.csv" : "run_" + std::to_string(k) + ".csv";
    add_recording(scenario,
                  simulated_recording(truth, drive, {{0.0, 0.0}, {0.0, 0.0}, false}, available_engines().front(), file,
                                      noise, static_cast<std::uint64_t>(k) + 3),
                  role);
    ++k;
  }
  return scenario;
}

/// Everything that a Problem refers to, kept alive.
struct Setting {
  explicit Setting(Scenario given, double step = 0.005, const std::string& engine = "featherstone",
                   Coordinates coordinates = Coordinates::values)
      : scenario(std::move(given)),
        model(scenario),
        experiment(make_experiment(scenario)),
        space(model, scenario, coordinates),
        problem(model, experiment, space, on(engine, step), first_weights(model, experiment)),
        train(experiment.with_role(Role::train)) {}
  Scenario scenario;
  PlantModel model;
  Experiment experiment;
  SearchSpace space;
  Problem problem;
  std::vector<int> train;
};

}  // namespace lacuna::test
