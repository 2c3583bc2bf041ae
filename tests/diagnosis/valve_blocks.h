// A block that a valve's flow moves along its slide, recordings made by another engine than the one that identifies.
#pragma once

#include <cmath>

#include "tests/physics/plants.h"

namespace lacuna::test {

inline constexpr double kValveGain = 0.2;       // m/(s V)
inline constexpr double kPositionNoise = 1e-4;  // m

/// A block behind a valve, 20 s a recording, its positions read with noise.
inline Scenario valve_block(std::vector<EffectSpec> concealed, double amplitude = 6.0) {
  const std::map<std::string, double> numbers{{"gain", kValveGain}, {"stiffness", 1e5}, {"damping", 1e3}};
  const Start rest{{0.0}, {0.0}, false};
  Scenario out = bare_scenario(block_robot(), {actuator("slide", "flow_source", numbers)}, false);
  const Role roles[] = {Role::train, Role::train, Role::validate, Role::test};
  Noise noise(5);
  for (int r = 0; r < 4; ++r) {
    const Drive drive = sine_drive(1, 20.0, 0.01, amplitude, 1.7 * r);
    Scenario moved = driven_scenario(out.robot, out.actuators, drive, rest);
    moved.effects = concealed;
    const auto q = predict_one(PlantModel(moved), started_experiment(moved, rest), on(engine_of_data(), 0.002));
    auto data = std::make_shared<Recording>(*recording_of(*out.robot, drive, rest, "run_" + std::to_string(r)));
    for (std::size_t k = 0; k < drive.time.size(); ++k) data->columns[2][k] = q[0][0][k] + kPositionNoise * noise();
    add_recording(out, data, roles[r]);
  }
  return out;
}

inline std::vector<EffectSpec> worn_valve() {
  return {effect("input_delay", "slide", {{"T", 0.11}}), effect("valve_deadband", "slide", {{"d", 1.5}}),
          effect("valve_asymmetry", "slide", {{"a", 0.3}}),
          effect("actuator_saturation", "slide", {{"cap", 2.0}, {"n", 8.0}})};
}

/// m/s, in the steady state.
inline double speed_of_worn_valve(double u) {
  const double open = std::copysign(std::max(std::fabs(u) - 1.5, 0.0), u);
  const double capped = open * std::pow(1.0 + std::pow(std::fabs(open) / 2.0, 8.0), -1.0 / 8.0);
  return kValveGain * (capped < 0.0 ? 0.7 * capped : capped);
}

}  // namespace lacuna::test
