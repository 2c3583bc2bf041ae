// Events as tests write them, and plants that they happen to.
#pragma once

#include "physics/events.h"
#include "tests/physics/plants.h"

namespace lacuna::test {

inline Event push_on(int joint, double begin, double end, double value, double rise = 0.0) {
  return {EventSpec::Kind::effort, joint, begin, end, value, rise};
}
inline Event command_of(int joint, double begin, double end, double value) {
  return {EventSpec::Kind::command, joint, begin, end, value, 0.0};
}
inline Event slip_of(int joint, double begin, double end, double value) {
  return {EventSpec::Kind::reading, joint, begin, end, value, 0.0};
}
/// As a scenario has it, on the recording's own clock.
inline EventSpec event_spec(EventSpec::Kind kind, const std::string& joint, double from, double to, double value,
                            double rise = 0.0) {
  return {kind, joint, "run.csv", from, to, value, rise, "test: events"};
}

/// The block on a spring, pushed by three sines.
struct SprungBlock {
  Start start{{0.1}, {0.0}};
  Drive drive = sine_drive(1, 3.0, 0.01, 4.0);
  Scenario scenario = driven_scenario(
      block_robot(), {actuator("slide", "torque_source", {{"gain", 3.0}, {"damping", 1.0}, {"stiffness", 20.0}})},
      drive, start);
};

/// Two rods on springs, swung by three sines each.
struct DrivenRods {
  Start start{{0.3, -0.4}, {0.2, -0.1}};
  Scenario scenario =
      driven_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                      {actuator("shoulder", "torque_source", {{"gain", 3.0}, {"damping", 0.7}, {"stiffness", 2.0}}),
                       actuator("elbow", "torque_source", {{"gain", 3.0}, {"damping", 0.7}, {"stiffness", 2.0}})},
                      sine_drive(2, 2.0, 0.01, 2.0), start);
  PlantModel model{scenario};
  Experiment experiment = started_experiment(scenario, start);

  Experiment with(const std::vector<Event>& events) const {
    Experiment out = experiment;
    for (const Event& event : events) add_event(out.segments[0], event);
    return out;
  }
};

/// A rod that nothing moves: no drive, no weight.
struct FreeRod {
  static constexpr double kInertia = 0.0833667 + 1.0 * 0.5 * 0.5;  // kg m^2, about its pivot: pendulum.urdf
  Start start{{0.3}, {0.0}};
  Scenario scenario = weightless();
  Scenario weightless() const {
    Scenario out =
        driven_scenario(bundled_robot("pendulum/pendulum.urdf"), {}, constant_drive(1, 2.0, 0.02, 0.0), start);
    out.gravity.setZero();
    return out;
  }
  /// [segment][channel][sample]
  std::vector<std::vector<std::vector<double>>> moved(Experiment experiment, const Event& push,
                                                      const std::string& engine = "featherstone") const {
    for (Segment& segment : experiment.segments) add_event(segment, push);
    return predict_one(PlantModel(scenario), experiment, on(engine, 0.005));
  }
};

}  // namespace lacuna::test
