// `lacuna diagnose`: what the scenario's model leaves out, where, and how much.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "cli/diagnose_run.h"
#include "cli/files.h"
#include "cli/pictures.h"
#include "cli/progress.h"
#include "cli/table.h"
#include "diagnosis/checkpoint.h"
#include "diagnosis/diagnosis.h"
#include "reports/json.h"
#include "reports/wording.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScenarioName = "scenario.diagnosed.yaml";

std::vector<std::string> marked_joints(const Scenario& scenario, const Diagnosis& diagnosis) {
  std::vector<std::string> out;
  const auto mark = [&](const std::string& place) {
    const bool marked = std::find(out.begin(), out.end(), place) != out.end();
    if (!marked && scenario.robot->find_joint(place)) out.push_back(place);
  };
  for (const Finding& finding : diagnosis.findings) mark(finding.place);
  for (const std::string& place : diagnosis.unexplained.where) mark(place);
  return out;
}

/// The scenario that runs again as it is, and the robot beside it.
std::vector<std::string> write_model(const fs::path& folder, const Scenario& scenario, const Diagnosis& diagnosis) {
  Scenario diagnosed = diagnosed_scenario(scenario, diagnosis);
  diagnosed.name += "-diagnosed";
  // Link masses come before the effects in the list of values: the plain plant reads them.
  const PlantModel plain(scenario);
  return write_model_files(folder, kScenarioName, scenario, diagnosed, plain.link_masses(diagnosis.after.values));
}

std::string findings_table(const Diagnosis& diagnosis) {
  TextTable table({"effect", "where", ">probability", "parameters", "may as well be"});
  for (const Finding& finding : diagnosis.findings) {
    std::vector<std::string> parameters, others;
    for (const Estimate& estimate : finding.parameters)
      parameters.push_back(estimate.name + " = " + with_interval(estimate));
    for (const std::string& name : finding.members) {
      if (name == finding.effect) continue;
      const auto rival = std::ranges::find_if(finding.rivals, [&](const Rival& r) { return r.effect == name; });
      others.push_back(rival == finding.rivals.end() ? name : name + " (" + probability(rival->probability) + ")");
    }
    table.add(
        {finding.effect, finding.place, probability(class_probability(finding)), list_of(parameters), list_of(others)});
  }
  return table.empty() ? "" : table.str() + "\n";
}

std::string summary(const Scenario& scenario, const Diagnosis& diagnosis) {
  std::string out = wrapped(verdict_sentence(scenario, diagnosis), 110, 0) + "\n\n" + findings_table(diagnosis);
  const Role role = judged_role(diagnosis.before);
  TextTable table({fmt::format("residual rms, {}", to_string(role)), ">before", ">after", ">noise", "unit"});
  for (const auto& [entry, before] : rms_in(diagnosis.before, role))
    table.add({entry, steady(before), steady(entry_of(rms_in(diagnosis.after, role), entry)),
               steady(entry_of(diagnosis.noise, entry)), residual_unit(scenario, &diagnosis, entry)});
  return out + table.str();
}

void run(Session& session, const DiagnoseFlags& flags) {
  engine_named(flags.identify.engine);
  flags.identify.understood(session, flags.identify.engine);  // refuses unknown names at once
  Scenario loaded = load_scenario(session.scenario_file);
  load_meshes(loaded, flags.identify.package_paths);
  const Scenario scenario = std::move(loaded);
  check_diagnosable(scenario);
  log_notes(scenario);
  const fs::path folder = session.output_folder(scenario);
  refuse_overwriting(scenario.file, folder / kScenarioName);
  const Diagnosis diagnosis = [&] {
    ProgressLine progress("preparing");
    return run_diagnosis(session, flags, scenario, folder, progress.callback());
  }();
  if (!session.first()) return;
  std::vector<std::string> written = write_model(folder, scenario, diagnosis);
  std::vector<Picture> pictures;
  if (!flags.identify.no_pictures) pictures = report_pictures(folder, scenario, marked_joints(scenario, diagnosis));
  const Context context = session.context();
  const std::vector<std::string> reports = write_diagnosis_report(folder, scenario, diagnosis, context, pictures);
  DiagnosisCheckpoint::remove(folder / "checkpoint.json");
  if (session.json) {
    print(to_json(diagnosis, context) + "\n");
    return;
  }
  written.insert(written.begin(), reports.begin(), reports.end());
  print(summary(scenario, diagnosis) +
        fmt::format("\n{}; written to {}: {}\n", duration(diagnosis.seconds), folder.string(), list_of(written)));
}

}  // namespace

void add_diagnose(CLI::App& app, Session& session) {
  auto flags = std::make_shared<DiagnoseFlags>();
  CLI::App& command = add_scenario_command(
      app, session, "diagnose",
      "Finds the physics that the model leaves out: where, what, how much, and how far the fit improves.\n"
      "Writes diagnosis.json, report.html, scenario.diagnosed.yaml and the identified robot to -o DIR, else\n"
      "out/<name>; for a finding whose effect has look-alikes also separating_N.csv, the commands that would\n"
      "tell them apart; interrupted, the same command resumes",
      "lacuna diagnose my_arm/scenario.yaml -o out/my_arm", [&session, flags] { run(session, *flags); });
  flags->add_to(command);
}

}  // namespace lacuna
