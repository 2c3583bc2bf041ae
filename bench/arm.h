// The six-joint arm that every benchmark runs, with commands made in memory.
#pragma once

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "backends/engine.h"
#include "physics/simulator.h"
#include "scenarios/scenario.h"

namespace lacuna::bench {

inline std::shared_ptr<const Robot> arm_robot() {
  return Robot::from_urdf(std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios/hydrolek/seed_table1.urdf");
}

/// Six damped springs, one recording of `seconds` at 100 Hz with a sine on every command; gains are free.
inline Scenario arm_scenario(double seconds) {
  Scenario scenario;
  scenario.file = "bench/scenario.yaml";
  scenario.robot = arm_robot();
  const double gain[6] = {128, 177, 71, 3, 8.6, 1.5}, damping[6] = {208, 239, 84, 3.6, 9.2, 0.56};
  const double stiffness[6] = {1570, 3870, 960, 46, 84, 7.8};
  auto data = std::make_shared<Recording>();
  data->file = "bench.csv";
  data->names = {"t"};
  data->columns.emplace_back();
  const int samples = static_cast<int>(std::lround(seconds * 100.0)) + 1;
  for (int k = 0; k < samples; ++k) data->columns[0].push_back(0.01 * k);
  scenario.channels.time = "t";
  for (std::size_t j = 0; j < 6; ++j) {
    const std::string& joint = scenario.robot->joints()[j].name;
    scenario.actuators.push_back(
        {joint,
         "torque_source",
         {{"gain", gain[j]}, {"damping", damping[j]}, {"stiffness", stiffness[j]}, {"rest", 0.0}},
         "bench"});
    scenario.channels.of[ChannelKind::command][joint] = {"u_" + joint, 1.0, 0.0, ""};
    scenario.channels.of[ChannelKind::position][joint] = {"q_" + joint, 1.0, 0.0, ""};
    data->names.insert(data->names.end(), {"u_" + joint, "q_" + joint});
    data->columns.resize(data->columns.size() + 2);
    for (const double t : data->columns[0]) {
      data->columns[data->columns.size() - 2].push_back(4.0 * std::sin(2.0 * t * (1.0 + 0.2 * static_cast<double>(j))));
      data->columns.back().push_back(0.0);
    }
    scenario.noise[ChannelKind::position][joint] = 1e-3;
  }
  scenario.identify = {{"gain", true, 0.5, 2.0, "bench"}};
  RecordingSpec spec;
  spec.file = data->file;
  spec.data = data;
  spec.where = "bench";
  scenario.recordings.push_back(spec);
  return scenario;
}

/// The same arm moved by cylinders and rotary actuators of plausible size (oil rings at 4 to 80 Hz), same recording.
inline Scenario hydraulic_arm_scenario(double seconds) {
  Scenario scenario = arm_scenario(seconds);
  struct Size {
    double gain, area_a, area_b, dead, stroke, lever_a, lever_b, lever_angle;  // SI; lever_a 0: rotary
  };
  const Size sizes[6] = {{5.0e-9, 40e-6, 40e-6, 25e-6, 2.2, 0.0, 0.0, 0.0},
                         {5.7e-9, 12.57e-4, 9.42e-4, 28e-6, 0.134, 0.30, 0.078, 1.047},
                         {4.3e-9, 8.04e-4, 6.03e-4, 25e-6, 0.105, 0.24, 0.060, 2.356},
                         {4.2e-9, 20e-6, 20e-6, 20e-6, 5.0, 0.0, 0.0, 0.0},
                         {3.0e-9, 4.91e-4, 3.78e-4, 22e-6, 0.068, 0.15, 0.040, 1.484},
                         {4.2e-9, 8e-6, 8e-6, 20e-6, 20.0, 0.0, 0.0, 0.0}};
  for (std::size_t j = 0; j < 6; ++j) {
    const Size& s = sizes[j];
    scenario.actuators[j].model = "hydraulic";
    scenario.actuators[j].parameters = {{"gain", s.gain},           {"full_command", 10.0},
                                        {"area_a", s.area_a},       {"area_b", s.area_b},
                                        {"dead_volume_a", s.dead},  {"dead_volume_b", s.dead},
                                        {"stroke", s.stroke},       {"lever_a", s.lever_a},
                                        {"lever_b", s.lever_b},     {"lever_angle", s.lever_angle},
                                        {"supply_pressure", 160e5}, {"return_pressure", 5e5},
                                        {"relief_pressure", 200e5}, {"hose_compliance", 1.0 / 1.5e8}};
  }
  return scenario;
}

}  // namespace lacuna::bench
