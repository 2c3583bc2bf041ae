// Machines whose recordings hold what the catalogue has no name for: made by the truth's own integrator on another
// engine, and what is asked of their diagnosis.
#pragma once

#include <unistd.h>

#include <functional>

#include "diagnosis/diagnosis.h"
#include "physics/truth.h"
#include "tests/ga/plant_problems.h"

namespace lacuna::test {

inline constexpr double kTransducerNoise = 1e-3;  // rad, of a reading
inline constexpr double kRecordedFor = 20.0;      // s
inline const PendulumTruth kGuessed{2.2, 1.1, 5.0, 1.0};
inline const std::vector<Role> kEveryRole{Role::train, Role::validate, Role::test};

/// Another engine than the one that diagnoses, where there is one; ODE's accelerations are good to 1e-5 only.
inline std::string another_engine() {
  for (const std::string& engine : available_engines())
    if (engine != "featherstone" && engine != "ode") return engine;
  return available_engines().front();
}

/// A parameter of a machine's effect that is not the same all along its way (physics/truth.h).
struct Unevenness {
  std::string parameter;
  UnevenParameter along;  ///< whose number is filled in
};

/// What the machine of `truth` reads of its positions, from rest, with what is outside the catalogue.
inline std::shared_ptr<Recording> recording_with(const std::vector<OutsidePhysics>& outside, Scenario truth,
                                                 const Drive& drive, const std::string& file, std::uint64_t seed,
                                                 const std::vector<Unevenness>& uneven = {}) {
  const std::vector<double> rest(truth.robot->dof(), 0.0);
  const auto data = recording_of(*truth.robot, drive, {rest, rest, false}, file);
  truth.recordings.clear();
  add_recording(truth, data);
  const PlantModel model(truth);
  const Experiment experiment = make_experiment(truth);
  TruthOptions options;
  options.engine = another_engine();
  options.outside = outside;
  for (const Unevenness& u : uneven) {
    options.uneven.push_back(u.along);
    options.uneven.back().parameter = model.find(u.parameter);
  }
  const auto read = simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
  Noise random(seed);
  for (std::size_t c = 0; c < read.size(); ++c) {
    const std::string& joint = experiment.joint_names[experiment.channels[c].joint];
    std::vector<double>& column = data->columns[data->find("q_" + joint)];
    column = read[c];
    for (double& x : column) x += kTransducerNoise * random();
  }
  return data;
}

/// What is searched of a plain machine, and what is known of its noise.
inline void search_plain_numbers(Scenario& scenario) {
  for (const char* name : {"gain", "damping", "stiffness"})
    scenario.identify.push_back({name, true, 0.2, 5.0, std::string("test: identify.") + name});
  for (const Joint& joint : scenario.robot->joints())
    scenario.noise[ChannelKind::position][joint.name] = kTransducerNoise;
}

/// What is outside the catalogue in the recording of a role.
using OutsideOf = std::function<std::vector<OutsidePhysics>(Role)>;

/// The plain pendulum, from wrong numbers, on recordings of one with more in it.
inline Scenario guessed_pendulum(const OutsideOf& outside, const std::vector<Role>& roles = kEveryRole,
                                 std::uint64_t seed = 11) {
  Scenario out = pendulum_scenario(kGuessed);
  for (const Role role : roles) {
    const auto k = static_cast<std::uint64_t>(role);
    const Drive drive = rested_drive(kRecordedFor, 7.3 * static_cast<double>(k));
    const std::string file = std::string(to_string(role)) + ".csv";
    add_recording(out, recording_with(outside(role), pendulum_scenario({}), drive, file, seed + k), role);
  }
  search_plain_numbers(out);
  return out;
}

inline Diagnosis diagnosed(const Scenario& scenario, int threads = 2) {
  DiagnoseOptions options;
  options.identify.optimizer = Optimizer::lsq;
  options.identify.simulator.threads = threads;
  options.other_engines = false;
  return diagnose(scenario, options);
}

/// Of the first joint; NaN where there is none of that role.
inline double rms_in_role(const FitResult& fit, Role of) {
  for (const auto& [role, rms] : fit.rms)
    if (role == of) return rms.front().second;
  return kMissing;
}

/// A pendulum's scenario written with its recordings, and read again.
inline Scenario saved_and_read(Scenario scenario) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("lacuna_outside_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  fs::copy_file(fs::path(LACUNA_SOURCE_DIR) / "scenarios/pendulum/pendulum.urdf", folder / "pendulum.urdf",
                fs::copy_options::overwrite_existing);
  for (const RecordingSpec& recording : scenario.recordings) write_csv(folder / recording.file, *recording.data);
  scenario.file = folder / "scenario.diagnosed.yaml";
  scenario.robot_file = "pendulum.urdf";
  save_scenario(scenario, scenario.file);
  const Scenario out = load_scenario(scenario.file);
  fs::remove_all(folder);
  return out;
}

}  // namespace lacuna::test
