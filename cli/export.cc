// `lacuna export`: the scenario's robot with its numbers, for other tools.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/mjcf.h"
#include "cli/settings.h"
#include "reports/json_text.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/urdf_write.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct ExportOptions {
  std::string format;
  std::vector<std::string> settings;
};

/// URDF holds the masses; what drives the joints is told in comments.
std::string urdf_text(const SetPlant& plant) {
  return commented_urdf(plant.model.robot(), plant.model.link_masses(plant.values),
                        plant_in_words(plant.model, plant.values));
}

void run(const Session& session, const ExportOptions& options) {
  if (options.format != "mjcf" && options.format != "urdf")
    throw InputError("--format", quoted(options.format), "mjcf or urdf");
  const Scenario scenario = load_scenario(session.scenario_file, {.load_recordings = false});
  const SetPlant plant = plant_with(scenario, options.settings);
  log_notes(scenario);
  const bool mjcf = options.format == "mjcf";
  const std::string text = mjcf ? to_mjcf(plant.model, plant.values) : urdf_text(plant);
  Json record = {
      {"format", "lacuna-export/1"}, {"version", version()}, {"scenario", scenario.name}, {"as", options.format}};
  if (session.output.empty()) {
    record["text"] = text;
    print(session.json ? json_text(record) : text);
    return;
  }
  const fs::path file = session.output_folder(scenario) / (file_name(scenario.name) + (mjcf ? ".xml" : ".urdf"));
  refuse_overwriting(resolve(scenario, scenario.robot_file), file);
  write_file_atomically(file, text);
  record["written"] = file.string();
  print(session.json ? json_text(record) : file.string() + "\n");
}

}  // namespace

void add_export(CLI::App& app, Session& session) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App& command = add_scenario_command(
      app, session, "export",
      "The scenario's robot and numbers as MJCF or URDF: to standard output, with -o as DIR/<name>.xml or .urdf",
      "lacuna export out/my_arm/scenario.diagnosed.yaml --format mjcf > my_arm.xml",
      [&session, options] { run(session, *options); });
  command.add_option("--format", options->format, "mjcf or urdf")->required();
  command.add_option("--set", options->settings, "NAME=VALUE: a parameter changed; may be repeated")
      ->allow_extra_args(false);
}

}  // namespace lacuna
