// Scenario to YAML. What is written loads to the same values.
#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "scenarios/bag.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/learned_entry.h"
#include "scenarios/scenario.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/text.h"

namespace lacuna {
namespace fs = std::filesystem;

namespace {

std::string number_map(const std::map<std::string, double>& values) {
  std::string out;
  for (const auto& [name, value] : values)
    out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", yaml_scalar(name), format_number(value));
  return "{" + out + "}";
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

std::string actuators_text(const Scenario& scenario) {
  std::string out;
  for (const ActuatorSpec& spec : scenario.actuators) {
    out += fmt::format("  {}: {{model: {}", yaml_scalar(spec.joint), yaml_scalar(spec.model));
    for (const auto& [name, value] : spec.parameters)
      out += fmt::format(", {}: {}", yaml_scalar(name), format_number(value));
    out += "}\n";
  }
  return out.empty() ? out : "actuators:\n" + out;
}

std::string identify_text(const Scenario& scenario) {
  std::string out;
  for (const IdentifySpec& spec : scenario.identify)
    out += fmt::format("  {}: {{{}: [{}, {}]}}\n", yaml_scalar(spec.name), spec.relative ? "relative_bounds" : "bounds",
                       format_number(spec.lower), format_number(spec.upper));
  return out.empty() ? out : "identify:\n" + out;
}

std::string column_text(const ColumnSpec& spec) {
  if (spec.scale == 1.0 && spec.offset == 0.0 && spec.unit.empty()) return yaml_scalar(spec.column);
  std::string out = "{column: " + yaml_scalar(spec.column);
  if (spec.scale != 1.0) out += ", scale: " + format_number(spec.scale);
  if (spec.offset != 0.0) out += ", offset: " + format_number(spec.offset);
  if (!spec.unit.empty()) out += ", unit: " + yaml_scalar(spec.unit);
  return out + "}";
}

std::string channels_text(const Scenario& scenario) {
  std::string out;
  if (!scenario.channels.time.empty()) out += "  time: " + yaml_scalar(scenario.channels.time) + "\n";
  for (const auto& [kind, joints] : scenario.channels.of) {
    out += fmt::format("  {}:\n", to_string(kind));
    for (const auto& [joint, spec] : joints) out += fmt::format("    {}: {}\n", yaml_scalar(joint), column_text(spec));
  }
  return out.empty() ? out : "channels:\n" + out;
}

std::string noise_text(const Scenario& scenario) {
  std::string out;
  for (const auto& [kind, joints] : scenario.noise)
    out += fmt::format("  {}: {}\n", to_string(kind), number_map(joints));
  return out.empty() ? out : "noise:\n" + out;
}

std::string part_text(const RecordingPart& part, const std::string& file) {
  std::string out = "{file: " + yaml_scalar(file);
  if (part.clock_offset) out += ", clock_offset: " + format_number(*part.clock_offset);
  if (!part.time.empty()) out += ", time: " + yaml_scalar(part.time);
  if (!part.prefix.empty()) out += ", prefix: " + yaml_scalar(part.prefix);
  if (part.log_times) out += ", stamps: log";
  return out + "}";
}

std::string recordings_text(const Scenario& scenario, const std::map<std::string, std::string>& moved) {
  std::string out;
  for (const RecordingSpec& spec : scenario.recordings) {
    out += fmt::format("  - {{file: {}, role: {}", yaml_scalar(moved.at(spec.file)), to_string(spec.role));
    if (spec.from) out += ", from: " + format_number(*spec.from);
    if (spec.to) out += ", to: " + format_number(*spec.to);
    if (spec.log_times) out += ", stamps: log";
    std::string with;
    for (const RecordingPart& part : spec.with)
      with += (with.empty() ? "" : ", ") + part_text(part, moved.at(part.file));
    if (!with.empty()) out += ", with: [" + with + "]";
    out += "}\n";
  }
  return out.empty() ? out : "recordings:\n" + out;
}

std::string effects_text(const Scenario& scenario, const std::map<std::string, std::string>& moved) {
  std::string out;
  for (const EffectSpec& spec : scenario.effects) {
    out += fmt::format("  - {{effect: {}, where: {}", yaml_scalar(spec.effect), yaml_scalar(spec.place));
    if (is_learned(spec.effect))
      out += curve_text(spec, *scenario.robot);
    else if (!spec.parameters.empty())
      out += ", parameters: " + number_map(spec.parameters);
    std::string files;
    for (const std::string& file : spec.recordings) {
      const auto at = moved.find(file);
      files += (files.empty() ? "" : ", ") + yaml_scalar(at == moved.end() ? file : at->second);
    }
    out += files.empty() ? "}\n" : ", recordings: [" + files + "]}\n";
  }
  for (const EventSpec& event : scenario.events)
    out += fmt::format("  - {{effect: {}, where: {}, events: [{{recording: {}, from: {}, to: {}, value: {}{}}}]}}\n",
                       to_string(event.kind), yaml_scalar(event.joint), yaml_scalar(moved.at(event.file)),
                       format_number(event.from), format_number(event.to), format_number(event.value),
                       event.rise > 0.0 ? ", rise: " + format_number(event.rise) : "");
  return out.empty() ? out : "effects:\n" + out;
}

std::string prediction_text(const Prediction& prediction) {
  if (const auto* windows = std::get_if<Windows>(&prediction))
    return fmt::format("prediction: {{horizon: {}}}\n", format_number(windows->horizon));
  if (const auto* inverse = std::get_if<InverseDynamics>(&prediction))
    return fmt::format("prediction: {{inverse_dynamics: {{cutoff_hz: {}}}}}\n", format_number(inverse->cutoff_hz));
  return "prediction: free_run\n";
}

/// `commands` as seen from the new place.
std::string motion_text(const MotionSpec& motion, const std::string& commands) {
  std::string out = "motion:\n";
  if (motion.duration) out += "  duration: " + format_number(*motion.duration) + "\n";
  if (!motion.position.empty()) out += "  position: " + number_map(motion.position) + "\n";
  if (!motion.velocity.empty()) out += "  velocity: " + number_map(motion.velocity) + "\n";
  if (!commands.empty()) out += "  commands: " + yaml_scalar(commands) + "\n";
  if (motion.pickup_mass)
    out += fmt::format("  pickup: {{mass: {}, time: {}}}\n", format_number(*motion.pickup_mass),
                       format_number(motion.pickup_time));
  return out;
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
  std::string out =
      fmt::format("format: lacuna-scenario/1\nname: {}\nrobot: {}\ngravity: [{}, {}, {}]\n", yaml_scalar(scenario.name),
                  yaml_scalar(mover.robot()), format_number(g[0]), format_number(g[1]), format_number(g[2]));
  if (scenario.sample_period) out += "sample_period: " + format_number(*scenario.sample_period) + "\n";
  if (scenario.total_mass) out += "total_mass: " + format_number(*scenario.total_mass) + "\n";
  out += actuators_text(scenario) + identify_text(scenario) + channels_text(scenario) + noise_text(scenario) +
         recordings_text(scenario, moved) + effects_text(scenario, moved) + prediction_text(scenario.prediction);
  if (scenario.motion) {
    const std::string& commands = scenario.motion->commands;
    out += motion_text(*scenario.motion, commands.empty() ? commands : mover.recording(commands));
  }
  write_file_atomically(file, out);
}

}  // namespace lacuna
