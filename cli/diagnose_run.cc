#include "cli/diagnose_run.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/files.h"
#include "scenarios/error.h"

namespace lacuna {

void DiagnoseFlags::add_to(CLI::App& command) {
  // Every fit begins at the scenario's start values as well, and the physics sought bends the valley that the search
  // would find the bottom of: a short look around.
  constexpr int kGenerations = 20;
  identify.generations = kGenerations;
  identify.add_to(command, false);
  command.add_flag("--no-engines", no_engines, "Leaves out the check of the found model on the other engines");
}

void check_diagnosable(const Scenario& scenario) {
  const PlantModel model(scenario);
  const SearchSpace space(model, scenario);
  if (make_experiment(scenario).with_role(Role::train).empty())
    throw InputError(scenario.file.string() + ": recordings", "none with role train", "at least one");
}

std::string diagnosis_fingerprint(const Session& session, const DiagnoseFlags& flags, const Scenario& scenario) {
  std::vector<std::string> words = flags.identify.words();
  words.push_back(flags.identify.engine);
  words.push_back(fmt::format("generations {} seed {}", flags.identify.generations, session.seed));
  return fingerprint(scenario, words);
}

Diagnosis run_diagnosis(Session& session, const DiagnoseFlags& flags, const Scenario& scenario,
                        const std::filesystem::path& folder, std::function<void(const Progress&)> progress) {
  DiagnoseOptions options;
  options.identify = flags.identify.understood(session, engine_named(flags.identify.engine));
  options.other_engines = !flags.no_engines;
  RunControl& control = options.identify.control;
  control.checkpoint = folder / "checkpoint.json";
  session.checkpoints = {control.checkpoint, folder / "checkpoint.search.json"};
  control.problem = diagnosis_fingerprint(session, flags, scenario);
  control.progress = std::move(progress);
  return diagnose(scenario, options);
}

}  // namespace lacuna
