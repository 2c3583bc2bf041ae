// Scenario to YAML. What is written loads to the same values.
#include <algorithm>
#include <system_error>

#include "scenarios/bag.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/learned_entry.h"
#include "scenarios/scenario.h"
#include "scenarios/scenario_entries.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/text.h"
#include "scenarios/yaml_writer.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

void put_numbers(YamlWriter& yaml, const std::string& key, const std::map<std::string, double>& values) {
  yaml.key(key).short_map();
  for (const auto& [name, value] : values) yaml.put(name, value);
  yaml.end();
}

/// Where the files of a scenario lie as seen from its new place.
class Mover {
 public:
  Mover(const Scenario& scenario, const fs::path& file)
      : scenario_(scenario),
        folder_(file.has_parent_path() ? file.parent_path() : fs::path(".")),
        stem_(file.stem().string()) {
    make_folder(folder_);
  }

  std::string robot() const { return relative(resolve(scenario_, scenario_.robot_file)); }

  /// A recording outside the new folder's tree is copied into it: paths must not leave a scenario's tree.
  std::string recording(const std::string& written) const {
    const fs::path source = resolve(scenario_, written);
    if (inside(folder_, source)) return relative(source);
    const fs::path local = fs::relative(fs::weakly_canonical(source), fs::weakly_canonical(scenario_folder()));
    const fs::path target = folder_ / (stem_ + ".recordings") / local;
    std::error_code error;
    if (fs::exists(source, error)) copy_recording(source, target);
    return relative(target);
  }

 private:
  fs::path scenario_folder() const { return scenario_.folder().empty() ? fs::path(".") : scenario_.folder(); }
  std::string relative(const fs::path& path) const {
    std::error_code error;
    const fs::path out = fs::relative(fs::weakly_canonical(path), fs::weakly_canonical(folder_), error);
    return error || out.empty() ? fs::absolute(path).string() : out.string();
  }

  const Scenario& scenario_;
  fs::path folder_;
  std::string stem_;
};

void put_actuators(YamlWriter& yaml, const Scenario& scenario) {
  if (scenario.actuators.empty()) return;
  yaml.key("actuators").map();
  for (const ActuatorSpec& spec : scenario.actuators) {
    yaml.key(spec.joint).short_map().put("model", spec.model);
    for (const auto& [name, value] : spec.parameters) yaml.put(name, value);
    yaml.end();
  }
  yaml.end();
}

void put_identify(YamlWriter& yaml, const Scenario& scenario) {
  if (scenario.identify.empty()) return;
  yaml.key("identify").map();
  for (const IdentifySpec& spec : scenario.identify) {
    yaml.key(spec.name).short_map();
    yaml.put(spec.relative ? "relative_bounds" : "bounds", {spec.lower, spec.upper}).end();
  }
  yaml.end();
}

void put_channels(YamlWriter& yaml, const Scenario& scenario) {
  const ChannelSpecs& channels = scenario.channels;
  if (channels.time.empty() && channels.of.empty()) return;
  yaml.key("channels").map();
  if (!channels.time.empty()) yaml.put("time", channels.time);
  for (const auto& [kind, joints] : channels.of) {
    yaml.key(to_string(kind)).map();
    for (const auto& [joint, spec] : joints) put_column(yaml, joint, spec);
    yaml.end();
  }
  yaml.end();
}

void put_noise(YamlWriter& yaml, const Scenario& scenario) {
  if (scenario.noise.empty()) return;
  yaml.key("noise").map();
  for (const auto& [kind, joints] : scenario.noise) put_numbers(yaml, to_string(kind), joints);
  yaml.end();
}

void put_part(YamlWriter& yaml, const RecordingPart& part, const std::string& file) {
  yaml.short_map().put("file", file);
  if (part.clock_offset) yaml.put("clock_offset", *part.clock_offset);
  if (!part.time.empty()) yaml.put("time", part.time);
  if (!part.prefix.empty()) yaml.put("prefix", part.prefix);
  if (part.log_times) yaml.put("stamps", "log");
  yaml.end();
}

void put_recordings(YamlWriter& yaml, const Scenario& scenario, const std::map<std::string, std::string>& moved) {
  if (scenario.recordings.empty()) return;
  yaml.key("recordings").list();
  for (const RecordingSpec& spec : scenario.recordings) {
    yaml.short_map().put("file", moved.at(spec.file)).put("role", to_string(spec.role));
    if (spec.from) yaml.put("from", *spec.from);
    if (spec.to) yaml.put("to", *spec.to);
    if (spec.log_times) yaml.put("stamps", "log");
    if (!spec.with.empty()) {
      yaml.key("with").short_list();
      for (const RecordingPart& part : spec.with) put_part(yaml, part, moved.at(part.file));
      yaml.end();
    }
    yaml.end();
  }
  yaml.end();
}

void put_effect(YamlWriter& yaml, const EffectSpec& spec, const Robot& robot,
                const std::map<std::string, std::string>& moved) {
  yaml.short_map().put("effect", spec.effect).put("where", spec.place);
  if (is_learned(spec.effect))
    put_curve(yaml, spec, robot);
  else if (!spec.parameters.empty())
    put_numbers(yaml, "parameters", spec.parameters);
  if (!spec.recordings.empty()) {
    yaml.key("recordings").short_list();
    for (const std::string& file : spec.recordings) {
      const auto at = moved.find(file);
      yaml.value(at == moved.end() ? file : at->second);
    }
    yaml.end();
  }
  yaml.end();
}

void put_event(YamlWriter& yaml, const EventSpec& event, const std::string& file) {
  yaml.short_map().put("effect", to_string(event.kind)).put("where", event.joint);
  yaml.key("events").short_list().short_map().put("recording", file).put("from", event.from).put("to", event.to);
  yaml.put("value", event.value);
  if (event.rise > 0.0) yaml.put("rise", event.rise);
  yaml.end().end().end();
}

void put_effects(YamlWriter& yaml, const Scenario& scenario, const std::map<std::string, std::string>& moved) {
  if (scenario.effects.empty() && scenario.events.empty()) return;
  yaml.key("effects").list();
  for (const EffectSpec& spec : scenario.effects) put_effect(yaml, spec, *scenario.robot, moved);
  for (const EventSpec& event : scenario.events) put_event(yaml, event, moved.at(event.file));
  yaml.end();
}

/// `commands` as seen from the new place.
void put_motion(YamlWriter& yaml, const MotionSpec& motion, const std::string& commands) {
  yaml.key("motion").map();
  if (motion.duration) yaml.put("duration", *motion.duration);
  if (!motion.position.empty()) put_numbers(yaml, "position", motion.position);
  if (!motion.velocity.empty()) put_numbers(yaml, "velocity", motion.velocity);
  if (!commands.empty()) yaml.put("commands", commands);
  if (motion.pickup_mass)
    yaml.key("pickup").short_map().put("mass", *motion.pickup_mass).put("time", motion.pickup_time).end();
  yaml.end();
}

}  // namespace

void save_scenario(const Scenario& scenario, const fs::path& file) {
  const Mover mover(scenario, file);
  std::map<std::string, std::string> moved;
  const auto move = [&](const std::string& one) {
    if (moved.count(one) == 0) moved[one] = mover.recording(one);
  };
  for (const RecordingSpec& spec : scenario.recordings) {
    move(spec.file);
    for (const RecordingPart& part : spec.with) move(part.file);
  }
  const Eigen::Vector3d& g = scenario.gravity;
  YamlWriter yaml;
  yaml.map().put("format", "lacuna-scenario/1").put("name", scenario.name).put("robot", mover.robot());
  yaml.put("gravity", {g[0], g[1], g[2]});
  if (scenario.sample_period) yaml.put("sample_period", *scenario.sample_period);
  if (scenario.total_mass) yaml.put("total_mass", *scenario.total_mass);
  put_actuators(yaml, scenario);
  put_identify(yaml, scenario);
  put_channels(yaml, scenario);
  put_noise(yaml, scenario);
  put_recordings(yaml, scenario, moved);
  put_effects(yaml, scenario, moved);
  put_prediction(yaml, scenario.prediction, scenario.pressure_driven);
  if (scenario.motion) {
    const std::string& commands = scenario.motion->commands;
    put_motion(yaml, *scenario.motion, commands.empty() ? commands : mover.recording(commands));
  }
  write_file_atomically(file, yaml.end().str() + "\n");
}

}  // namespace lacuna
