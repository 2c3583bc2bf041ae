// Cylinders on one joint, what they measure, and the independent integration that they are held against.
#pragma once

#include "physics/truth.h"
#include "tests/physics/plants.h"

namespace lacuna::test::hydraulic {

using Numbers = std::map<std::string, double>;

inline constexpr double kStep = 0.005;         // s, that the mechanics alone would do with
inline constexpr double kTenthOfNoise = 5e-5;  // rad: of .0005, the positions' noise on the arm
inline constexpr double kLaminar = 2e5;        // Pa, below which an orifice is laminar
inline constexpr double kBar = 1e5;            // Pa

/// A balanced rotor of 2 kg m^2: no gravity acts on it.
inline constexpr double kInertia = 2.0;
inline std::shared_ptr<const Robot> rotor() {
  return Robot::from_urdf_text(R"(<robot name='rotor'><link name='world_link'/>
  <link name='rotor'><inertial><mass value='5'/><inertia ixx='1' iyy='1' izz='2' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='swing' type='continuous'><parent link='world_link'/><child link='rotor'/><axis xyz='0 0 1'/></joint></robot>)",
                               "rotor");
}

/// A cylinder of 40 and 20 mm with short hoses, without leaks.
inline Numbers cylinder() {
  return {{"gain", 5.7e-9},
          {"full_command", 10.0},
          {"area_a", 1.2566e-3},
          {"area_b", 9.425e-4},
          {"dead_volume_a", 4e-5},
          {"dead_volume_b", 3e-5},
          {"stroke", 0.2},
          {"bulk_modulus", 1.2e9},
          {"supply_pressure", 160 * kBar},
          {"return_pressure", 5 * kBar}};
}
inline Numbers with(Numbers numbers, const Numbers& changed) {
  for (const auto& [name, value] : changed) numbers[name] = value;
  return numbers;
}
/// Equal areas, about the middle of the stroke equal volumes: m^2, m^3.
inline constexpr double kArea = 1e-3, kVolume = 5e-5 + kArea * 0.1;
inline Numbers symmetric(const Numbers& changed = {}) {
  return with(
      with(cylinder(), {{"area_a", kArea}, {"area_b", kArea}, {"dead_volume_a", 5e-5}, {"dead_volume_b", 5e-5}}),
      changed);
}
inline const Numbers kLever = {{"lever_a", 0.30}, {"lever_b", 0.078}, {"lever_angle", 1.5}};

/// The scenario with efforts and both pressures measured at every joint.
inline Scenario measured_whole(Scenario scenario) {
  auto data = std::make_shared<Recording>(*scenario.recordings[0].data);
  for (const Joint& joint : scenario.robot->joints()) {
    for (const auto& [kind, prefix] :
         {std::pair{ChannelKind::effort, "e_"}, {ChannelKind::pressure_a, "a_"}, {ChannelKind::pressure_b, "b_"}}) {
      scenario.channels.of[kind][joint.name] = {prefix + joint.name, 1.0, 0.0, ""};
      data->names.push_back(prefix + joint.name);
      data->columns.emplace_back(data->rows(), kMissing);
    }
  }
  scenario.recordings[0].data = data;
  return scenario;
}

/// All channels of one joint by kind.
struct Moved {
  std::vector<double> t;
  std::map<ChannelKind, std::vector<double>> of;
  const std::vector<double>& q() const { return of.at(ChannelKind::position); }
  const std::vector<double>& v() const { return of.at(ChannelKind::velocity); }
  const std::vector<double>& a() const { return of.at(ChannelKind::pressure_a); }
  const std::vector<double>& b() const { return of.at(ChannelKind::pressure_b); }
  const std::vector<double>& effort() const { return of.at(ChannelKind::effort); }
};
inline Scenario driven(std::shared_ptr<const Robot> robot, const Numbers& numbers, const Drive& drive,
                       const Start& start, std::vector<EffectSpec> effects = {}) {
  const std::string joint = robot->joints()[0].name;
  Scenario out = driven_scenario(std::move(robot), {actuator(joint, "hydraulic", numbers)}, drive, start);
  out.effects = std::move(effects);
  return measured_whole(std::move(out));
}
/// One joint, driven by pressures given as functions of time (Pa).
template <class A, class B>
Scenario pressed(std::shared_ptr<const Robot> robot, const Numbers& numbers, const A& a, const B& b,
                 std::vector<EffectSpec> effects = {}) {
  Scenario out =
      driven(std::move(robot), numbers, constant_drive(1, 1.0, 0.01, 3.0), {{0.0}, {0.0}}, std::move(effects));
  auto data = std::make_shared<Recording>(*out.recordings[0].data);
  const std::vector<double> time = data->columns[data->find("t")];
  const std::string& joint = out.robot->joints()[0].name;
  auto& head = data->columns[data->find("a_" + joint)];
  auto& rod = data->columns[data->find("b_" + joint)];
  for (std::size_t k = 0; k < time.size(); ++k) head[k] = a(time[k]), rod[k] = b(time[k]);
  out.recordings[0].data = data;
  out.pressure_driven = true;
  return out;
}
inline Moved simulated(const Scenario& scenario, const Start& start, double step = kStep,
                       const std::string& engine = "featherstone") {
  const Experiment experiment = started_experiment(scenario, start);
  const auto predicted = predict_one(PlantModel(scenario), experiment, on(engine, step)).front();
  Moved out{experiment.segments[0].commands->time, {}};
  for (std::size_t c = 0; c < predicted.size(); ++c) out.of[experiment.channels[c].kind] = predicted[c];
  return out;
}
/// A friction that nothing overcomes.
inline EffectSpec blocked(const std::string& joint) { return effect("coulomb_friction", joint, {{"Fc", 1e8}}); }

inline std::vector<std::vector<double>> reference_of(const PlantModel& model, const Experiment& experiment) {
  TruthOptions options;
  options.extended_precision = true;
  options.tolerance = 1e-11;
  return simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
}
inline double worst_of(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b,
                       std::size_t channels) {
  double worst = 0.0;
  for (std::size_t c = 0; c < channels; ++c) worst = std::max(worst, worst_difference(a[c], b[c]));
  return worst;
}

}  // namespace lacuna::test::hydraulic
