// Small plants, commands and simulations made in memory, for every test above the engines.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "backends/engine.h"
#include "physics/predictor.h"
#include "physics/simulator.h"
#include "scenarios/error.h"
#include "scenarios/scenario.h"

namespace lacuna::test {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// A robot of the bundled scenarios: "pendulum/pendulum.urdf".
inline std::shared_ptr<const Robot> bundled_robot(const std::string& file) {
  return Robot::from_urdf(std::filesystem::path(LACUNA_SOURCE_DIR) / "scenarios" / file);
}

/// A block of 2 kg on a level slide: friction, and nothing else, acts on it.
inline constexpr double kBlockMass = 2.0;  // kg
inline std::shared_ptr<const Robot> block_robot() {
  return Robot::from_urdf_text(R"(<robot name='block'><link name='world_link'/>
  <link name='block'><inertial><mass value='2'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='slide' type='prismatic'><parent link='world_link'/><child link='block'/><axis xyz='1 0 0'/>
  <limit lower='-100' upper='100' effort='1e9' velocity='1e9'/></joint></robot>)",
                               "block");
}

/// Engines that are built in.
inline std::vector<std::string> available_engines() {
  std::vector<std::string> names;
  for (const Engine* engine : engines()) {
    if (engine->info().available) names.push_back(engine->info().name);
  }
  return names;
}

/// An engine to make data with: another than the one that identifies, and a light one, since under sanitizers DART's
/// many allocations take minutes.
inline std::string engine_of_data() {
  const std::vector<std::string> names = available_engines();
  return std::ranges::count(names, "ode") > 0 ? "ode" : names.back();
}

/// Commands over time, one row a joint, held between their instants.
struct Drive {
  std::vector<double> time;            ///< s
  std::vector<std::vector<double>> u;  ///< [joint][sample], V
};

inline std::vector<double> clock(double seconds, double period) {
  std::vector<double> time;
  const int last = static_cast<int>(std::lround(seconds / period));
  for (int k = 0; k <= last; ++k) time.push_back(k * period);
  return time;
}

/// The same command throughout.
inline Drive constant_drive(int joints, double seconds, double period, double u) {
  Drive out{clock(seconds, period), {}};
  out.u.assign(joints, std::vector<double>(out.time.size(), u));
  return out;
}

/// Three sines a joint, none a multiple of another, every joint with its own.
inline Drive sine_drive(int joints, double seconds, double period, double amplitude, double shift = 0.0) {
  Drive out{clock(seconds, period), {}};
  for (int j = 0; j < joints; ++j) {
    std::vector<double> u;
    for (const double t : out.time) {
      const double phase = 2.0 * std::numbers::pi * (t + shift), f = 1.0 + 0.13 * j;
      u.push_back(
          amplitude / 3.0 *
          (std::sin(0.31 * f * phase) + std::sin(0.83 * f * phase + 1.0 + j) + std::sin(1.97 * f * phase + 2.0)));
    }
    out.u.push_back(std::move(u));
  }
  return out;
}

/// What a scenario measures, and what it says before anything was simulated: the start, at every sample.
struct Start {
  std::vector<double> q, v;  ///< one a joint
  bool velocities = true;    ///< velocity channels too
};

/// Columns t, u_<joint>, q_<joint>, v_<joint>.
inline std::shared_ptr<Recording> recording_of(const Robot& robot, const Drive& drive, const Start& start,
                                               const std::string& file = "run.csv") {
  auto out = std::make_shared<Recording>();
  out->file = file;
  out->names = {"t"};
  out->columns = {drive.time};
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const std::string& name = robot.joints()[j].name;
    out->names.insert(out->names.end(), {"u_" + name, "q_" + name, "v_" + name});
    out->columns.push_back(drive.u[j]);
    out->columns.emplace_back(drive.time.size(), start.q[j]);
    out->columns.emplace_back(drive.time.size(), start.v[j]);
  }
  return out;
}

inline ActuatorSpec actuator(const std::string& joint, const std::string& model,
                             std::map<std::string, double> parameters) {
  return {joint, model, std::move(parameters), "test: actuators." + joint};
}
inline EffectSpec effect(const std::string& name, const std::string& place, std::map<std::string, double> parameters,
                         std::vector<std::string> recordings = {}) {
  return {name, place, std::move(parameters), std::move(recordings), "test: effects"};
}

/// The scenario with drives on which that effect can act: some act on drives alone that integrate their flow.
inline Scenario with_drives_for(const EffectInfo& info, Scenario scenario) {
  if (!needs_flow(find_effect(info.name))) return scenario;
  for (ActuatorSpec& drive : scenario.actuators)
    drive = actuator(drive.joint, "flow_source", {{"gain", 0.2}, {"stiffness", 400.0}, {"damping", 20.0}});
  return scenario;
}

/// A scenario without recordings yet.
inline Scenario bare_scenario(std::shared_ptr<const Robot> robot, std::vector<ActuatorSpec> actuators,
                              bool velocities = true) {
  Scenario out;
  out.file = "test/scenario.yaml";
  out.name = "test";
  out.robot = std::move(robot);
  out.actuators = std::move(actuators);
  out.channels.time = "t";
  for (const Joint& joint : out.robot->joints()) {
    out.channels.of[ChannelKind::command][joint.name] = {"u_" + joint.name, 1.0, 0.0, ""};
    out.channels.of[ChannelKind::position][joint.name] = {"q_" + joint.name, 1.0, 0.0, ""};
    if (velocities) out.channels.of[ChannelKind::velocity][joint.name] = {"v_" + joint.name, 1.0, 0.0, ""};
  }
  return out;
}

inline void add_recording(Scenario& scenario, std::shared_ptr<const Recording> data, Role role = Role::train) {
  RecordingSpec spec;
  spec.file = data->file;
  spec.role = role;
  spec.data = std::move(data);
  spec.where = "test: recordings";
  scenario.recordings.push_back(std::move(spec));
}

/// One driven recording whose measured values are the start throughout.
inline Scenario driven_scenario(std::shared_ptr<const Robot> robot, std::vector<ActuatorSpec> actuators,
                                const Drive& drive, const Start& start) {
  Scenario out = bare_scenario(std::move(robot), std::move(actuators), start.velocities);
  add_recording(out, recording_of(*out.robot, drive, start));
  return out;
}

/// The experiment with every segment started exactly at `start`.
inline Experiment started_experiment(const Scenario& scenario, const Start& start) {
  Experiment out = make_experiment(scenario);
  for (Segment& segment : out.segments) segment.q0 = start.q, segment.v0 = start.v;
  return out;
}

/// [individual][segment][channel][sample]
using Predictions = std::vector<std::vector<std::vector<std::vector<double>>>>;

inline Predictions predict(const PlantModel& model, const Experiment& experiment,
                           const std::vector<std::vector<double>>& values, const SimulatorOptions& options) {
  std::vector<int> segments(experiment.segments.size());
  for (std::size_t s = 0; s < segments.size(); ++s) segments[s] = static_cast<int>(s);
  Predictions out(values.size(), std::vector<std::vector<std::vector<double>>>(segments.size()));
  make_simulator(model, experiment, options)->run(values, segments, [&](int i, int s, const auto& predicted) {
    out[i][s] = predicted;
  });
  return out;
}

/// One parameter vector: [segment][channel][sample].
inline std::vector<std::vector<std::vector<double>>> predict_one(const PlantModel& model, const Experiment& experiment,
                                                                 const SimulatorOptions& options) {
  return predict(model, experiment, {model.values()}, options).front();
}

inline SimulatorOptions on(const std::string& engine, double step, int threads = 1) {
  SimulatorOptions options;
  options.engine = engine;
  options.max_step = step;
  options.threads = threads;
  return options;
}

/// Position and velocity channel of a joint, as bare_scenario() lays them out.
inline std::size_t position_of(int joint) { return static_cast<std::size_t>(joint); }
inline std::size_t velocity_of(const Robot& robot, int joint) {
  return static_cast<std::size_t>(robot.dof()) + static_cast<std::size_t>(joint);
}

/// Largest difference of two equally long signals.
inline double worst_difference(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return HUGE_VAL;
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = std::fabs(a[i] - b[i]);
    worst = d <= worst ? worst : d;  // keeps NaN
  }
  return worst;
}

/// Same numbers to the last bit, NaN included (and unlike EXPECT_EQ without printing thousands of them).
inline bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
           return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
         });
}
template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](const T& x, const T& y) { return same_bits(x, y); });
}

/// Standard normal numbers from a fixed linear congruence (Knuth's MMIX) and Box and Muller: the same everywhere.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed * 2654435761u + 1u) {}
  double operator()() {
    const double u = uniform(), w = uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * w);
  }
  double uniform() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return (static_cast<double>(state_ >> 11) + 0.5) / 9007199254740992.0;
  }

 private:
  std::uint64_t state_;
};

/// The recording with positions (and velocities) replaced by what `engine` simulates for `truth`, plus white noise.
inline std::shared_ptr<const Recording> simulated_recording(const Scenario& truth, const Drive& drive,
                                                            const Start& start, const std::string& engine,
                                                            const std::string& file, double noise = 0.0,
                                                            std::uint64_t seed = 1, double step = 0.001) {
  Scenario scenario = truth;
  scenario.recordings.clear();
  scenario.prediction = FreeRun{};
  const auto data = recording_of(*truth.robot, drive, start, file);
  add_recording(scenario, data);
  const PlantModel model(scenario);
  const Experiment experiment = started_experiment(scenario, start);
  const auto predicted = predict_one(model, experiment, on(engine, step)).front();
  Noise random(seed);
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const std::string& joint = truth.robot->joints()[channel.joint].name;
    const std::string name = (channel.kind == ChannelKind::position ? "q_" : "v_") + joint;
    auto& column = data->columns[data->find(name)];
    column = predicted[c];
    if (noise > 0.0) {
      for (double& x : column) x += noise * random();
    }
  }
  return data;
}

/// The message of the InputError that `work` throws; empty if it throws none.
template <class Work>
std::string input_error(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace lacuna::test
