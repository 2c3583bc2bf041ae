// Small identification problems for a study: the bundled pendulum, and the seed's joint 2 with its truth.
#pragma once

#include "tests/ga/plant_problems.h"
#include "study/trial.h"

namespace lacuna::test {

inline constexpr double kStudyNoise = 1e-3;  // rad

/// A pendulum whose gain, damping and stiffness are searched; the truth is PendulumTruth's.
inline Scenario swinging(double noise = kStudyNoise) {
  return pendulum_problem({2.0, 1.5, 6.0, 1.0}, {"gain", "damping", "stiffness"}, noise);
}
inline Scenario swinging_truth() {
  Scenario out = pendulum_scenario({});
  out.file = "test/truth.yaml";
  return out;
}
inline Trial pendulum_trial(double noise = kStudyNoise) {
  const Scenario truth = swinging_truth();
  return make_trial(swinging(noise), &truth);
}

/// A bundled scenario of the arm.
inline Scenario bundled(const std::string& file, bool recordings = true) {
  return load_scenario(std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios/hydrolek" / file,
                       {.load_recordings = recordings});
}
inline Trial joint_2_trial() {
  const Scenario truth = bundled("joint_2_table1/truth.yaml", false);
  return make_trial(bundled("joint_2_table1.yaml"), &truth);
}

}  // namespace lacuna::test
