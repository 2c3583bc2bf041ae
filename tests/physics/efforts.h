// Two rods moved by efforts as told, measured with efforts: by the truth's own integrator.
#pragma once

#include "physics/truth.h"
#include "tests/physics/plants.h"

namespace lacuna::test {

inline const std::map<std::string, double> kDirect{{"gain", 1.0}, {"damping", 0.5}};

/// Two rods that hang; measured are positions, speeds and efforts.
inline Scenario pushed_rods(std::vector<EffectSpec> effects = {}, const std::string& drive = "direct_effort",
                            const std::map<std::string, double>& parameters = kDirect) {
  Scenario out = bare_scenario(bundled_robot("double_pendulum/double_pendulum.urdf"),
                               {actuator("shoulder", drive, parameters), actuator("elbow", drive, parameters)});
  for (const Joint& joint : out.robot->joints())
    out.channels.of[ChannelKind::effort][joint.name] = {"e_" + joint.name, 1.0, 0.0, ""};
  out.effects = std::move(effects);
  return out;
}

/// Three sines a joint, read at any times.
inline Drive sines_at(const std::vector<double>& time, double amplitude, double shift = 0.0) {
  Drive out{time, {{}, {}}};
  for (std::size_t j = 0; j < 2; ++j) {
    const double f = 1.0 + 0.13 * static_cast<double>(j);
    for (const double t : time) {
      const double phase = 2.0 * std::numbers::pi * (t + shift);
      out.u[j].push_back(amplitude / 3.0 *
                         (std::sin(0.31 * f * phase) + std::sin(0.83 * f * phase + static_cast<double>(j)) +
                          std::sin(1.97 * f * phase)));
    }
  }
  return out;
}

/// Everything that the channels of `truth` measure, from rest where the first commands hold it; efforts with white
/// noise of rms `noise` (N m).
inline std::shared_ptr<const Recording> truth_recording(Scenario truth, const Drive& drive, const std::string& file,
                                                        double noise = 0.0, std::uint64_t seed = 1) {
  const auto data = recording_of(*truth.robot, drive, {{0.0, 0.0}, {0.0, 0.0}}, file);
  for (const auto& [kind, joints] : truth.channels.of) {
    for (const auto& [joint, column] : joints) {
      if (data->find(column.column) >= 0) continue;
      data->names.push_back(column.column);
      data->columns.emplace_back(drive.time.size(), 0.0);
    }
  }
  truth.recordings.clear();
  truth.prediction = FreeRun{};
  add_recording(truth, data);
  const PlantModel model(truth);
  const Experiment experiment = make_experiment(truth);
  TruthOptions options;
  options.engine = "featherstone";
  const auto signals = simulate_truth(model, experiment.segments[0], experiment.channels, model.values(), options);
  Noise random(seed);
  for (std::size_t c = 0; c < signals.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const std::string& joint = experiment.joint_names[channel.joint];
    std::vector<double>& column = data->columns[data->find(truth.channels.of.at(channel.kind).at(joint).column)];
    column = signals[c];
    if (channel.kind != ChannelKind::effort) continue;
    for (double& x : column) x += noise * random();
  }
  return data;
}

inline double rms_of(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double y : x) sum += y * y;
  return std::sqrt(sum / static_cast<double>(x.size()));
}

}  // namespace lacuna::test
