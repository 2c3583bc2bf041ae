// `lacuna identify`: the scenario's free parameters from its recordings, on one engine or several.
#include "ga/identify.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "backends/engine.h"
#include "cli/files.h"
#include "cli/identify_flags.h"
#include "cli/pictures.h"
#include "cli/progress.h"
#include "cli/table.h"
#include "diagnosis/diagnosis.h"
#include "ga/checkpoint.h"
#include "reports/json.h"
#include "reports/wording.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

/// What is searched, and where the results go.
struct Search {
  Scenario scenario;
  PlantModel model;
  Experiment experiment;
  SearchSpace space;
};

Search load_search(const std::string& file, const IdentifyFlags& flags) {
  Scenario scenario = load_scenario(file);
  if (!flags.no_pictures) load_meshes(scenario, flags.package_paths);
  PlantModel model(scenario);
  Experiment experiment = make_experiment(scenario);
  SearchSpace space(model, scenario, Coordinates::ratios);
  if (space.size() == 0)
    throw InputError(scenario.file.string() + ": identify", "no free parameter",
                     "at least one, as gain: {relative_bounds: [0.5, 2]}");
  if (experiment.with_role(Role::train).empty())
    throw InputError(scenario.file.string() + ": recordings", "none with role train", "at least one");
  log_notes(scenario);
  return {std::move(scenario), std::move(model), std::move(experiment), std::move(space)};
}

/// One a engine, so that each resumes for itself.
fs::path checkpoint_of(const fs::path& folder, const std::string& engine, bool alone) {
  return folder / (alone ? "checkpoint.json" : "checkpoint." + engine + ".json");
}

std::vector<FitResult> fit_all(Session& session, const IdentifyFlags& flags, const Search& search,
                               const std::vector<std::string>& engines, const fs::path& folder) {
  std::vector<FitResult> out;
  ProgressLine progress("preparing");
  for (const std::string& engine : engines) {
    IdentifyOptions options = flags.understood(session, engine);
    options.start_errors = true;
    options.control.checkpoint = checkpoint_of(folder, engine, engines.size() == 1);
    session.checkpoints.push_back(options.control.checkpoint);
    std::vector<std::string> words = flags.words();
    words.push_back(engine);
    options.control.problem = fingerprint(search.scenario, words);
    options.control.progress = [&](const Progress& p) {
      progress.update(engines.size() == 1 ? p.stage : engine + ": " + p.stage, p.done);
    };
    out.push_back(identify(search.model, search.experiment, search.space, options));
  }
  return out;
}

/// Start and fit against one recording that was held back, for the report's plots.
std::vector<Trace> traces_of(const Search& search, const FitResult& fit, const SimulatorOptions& simulator) {
  std::vector<int> segments;
  for (const Role role : {Role::test, Role::validate, Role::train})
    if (segments.empty()) segments = search.experiment.with_role(role);
  const auto at = [&](int s) -> const Segment& { return search.experiment.segments[s]; };
  const std::string file = at(segments.front()).file;
  std::erase_if(segments, [&](int s) { return at(s).file != file; });
  const std::vector<Channel>& channels = search.experiment.channels;
  std::vector<std::vector<std::vector<std::vector<double>>>> predicted(
      2, std::vector<std::vector<std::vector<double>>>(search.experiment.segments.size()));
  const std::vector<std::vector<double>> both{search.model.values(), fit.values};
  make_simulator(search.model, search.experiment, simulator)->run(both, segments, [&](int i, int s, const auto& p) {
    predicted[i][s] = p;
  });
  std::vector<Trace> out;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (!is_leading(search.experiment, c)) continue;
    Trace trace{file, search.experiment.joint_names[channels[c].joint], channels[c].unit, {}, {}, {}, {}};
    for (const int s : segments) {
      const Segment& segment = at(s);
      const auto &before = predicted[0][s][c], &after = predicted[1][s][c];
      for (std::size_t k = 0; k < after.size(); ++k) {
        trace.time.push_back(segment.compared_time(k));
        trace.measured.push_back(segment.measured[c][k]);
        trace.before.push_back(before[k]);
        trace.after.push_back(after[k]);
      }
    }
    out.push_back(std::move(trace));
  }
  return out;
}

std::string remark(const Estimate& estimate) {
  if (estimate.at_bound) return "at its bound";
  if (!estimate.identifiable) return "not determined by these data";
  return estimate.derived ? "from the total mass" : "";
}

std::string summary(const Search& search, const std::vector<FitResult>& fits) {
  std::string out;
  for (const FitResult& fit : fits) {
    out += fmt::format("{} on {}, {}: {} evaluations in {}\n\n", search.scenario.name, fit.engine, fit.optimizer,
                       fit.evaluations, duration(fit.seconds));
    TextTable parameters({"parameter", ">value", "unit", "95 %", ""});
    for (const Estimate& estimate : fit.estimates)
      parameters.add({estimate.name, value_of(estimate), estimate.unit, interval(estimate), remark(estimate)});
    out += parameters.str() + "\n";
    TextTable rms({"residual rms", ">train", ">validate", ">test", "unit"});
    for (const auto& [entry, unused] : rms_in(fit, Role::train))
      rms.add({entry, steady(entry_of(rms_in(fit, Role::train), entry)),
               steady(entry_of(rms_in(fit, Role::validate), entry)), steady(entry_of(rms_in(fit, Role::test), entry)),
               residual_unit(search.scenario, nullptr, entry)});
    out += rms.str() + "\n";
    if (!fit.arrived) out += "the best may not have been reached: " + fit.doubt + "\n";
    for (const std::string& words : fit.undetermined) out += "not told apart by these data: " + words + "\n";
  }
  return out;
}

void run(Session& session, const IdentifyFlags& flags) {
  const std::vector<std::string> engines = engines_named(flags.engine);
  const IdentifyOptions options = flags.understood(session, engines.front());  // refuses unknown names at once
  const Search search = load_search(session.scenario_file, flags);
  const fs::path folder = session.output_folder(search.scenario);
  refuse_overwriting(search.scenario.file, folder / "scenario.identified.yaml");
  const std::vector<FitResult> fits = fit_all(session, flags, search, engines, folder);
  if (!session.first()) return;
  const FitResult& leading = fits.front();
  SimulatorOptions simulator = options.simulator;
  simulator.max_step = leading.step.step;
  const std::vector<Trace> traces = traces_of(search, leading, simulator);
  std::vector<Picture> pictures;
  if (!flags.no_pictures) pictures = report_pictures(folder, search.scenario, {});
  Scenario identified = with_values(search.scenario, search.model, leading.values);
  identified.name += "-identified";
  std::vector<std::string> written = write_model_files(folder, "scenario.identified.yaml", search.scenario, identified,
                                                       search.model.link_masses(leading.values));
  const Context context = session.context();
  write_fit_report(folder, search.scenario, fits, context, pictures, traces);
  for (const std::string& engine : engines) remove_checkpoint(checkpoint_of(folder, engine, engines.size() == 1));
  if (session.json) {
    print(to_json(fits, search.scenario.name, context) + "\n");
    return;
  }
  written.insert(written.begin(), {"report.html", "fit.json"});
  print(summary(search, fits) + "\nwritten to " + folder.string() + ": " + list_of(written) + "\n");
}

}  // namespace

void add_identify(CLI::App& app, Session& session) {
  auto flags = std::make_shared<IdentifyFlags>();
  CLI::App& command = add_scenario_command(
      app, session, "identify",
      "The free parameters from the train recordings, with intervals and what the data do not determine.\n"
      "Writes fit.json, report.html, the identified robot and scenario to -o DIR, else out/<name>;\n"
      "interrupted, the same command resumes",
      "lacuna identify my_arm/scenario.yaml --engine all --optimizer ga+lsq -o out/my_arm",
      [&session, flags] { run(session, *flags); });
  flags->add_to(command, true);
}

}  // namespace lacuna
