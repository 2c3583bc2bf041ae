#include "scenarios/scenario.h"

#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording_check.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/yaml_reader.h"

namespace lacuna {

const char* to_string(ChannelKind kind) {
  switch (kind) {
    case ChannelKind::command: return "command";
    case ChannelKind::position: return "position";
    case ChannelKind::velocity: return "velocity";
    case ChannelKind::effort: return "effort";
    case ChannelKind::motor_position: return "motor_position";
    case ChannelKind::pressure_a: return "pressure_a";
    case ChannelKind::pressure_b: return "pressure_b";
  }
  return "";
}

const char* to_string(EventSpec::Kind kind) {
  switch (kind) {
    case EventSpec::Kind::effort: return "learned_effort";
    case EventSpec::Kind::command: return "learned_command";
    default: return "learned_reading";
  }
}

const char* to_string(Role role) {
  switch (role) {
    case Role::train: return "train";
    case Role::validate: return "validate";
    case Role::test: return "test";
  }
  return "";
}

Scenario load_scenario(const std::filesystem::path& file, const ScenarioOptions& options) {
  const std::string text = read_text_file(file, file.string(), "a scenario file (scenario.yaml)", kYamlMaxBytes);
  const YamlNode tree = parse_yaml(text, file.string());
  Scenario scenario;
  scenario.file = file;
  ScenarioParser(YamlCursor(tree, file.string()), scenario).parse();
  if (options.load_recordings) load_and_check_recordings(scenario);
  return scenario;
}

}  // namespace lacuna
