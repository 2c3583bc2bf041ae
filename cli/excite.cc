// `lacuna excite`: commands that tell most of the free parameters.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "cli/command.h"
#include "cli/files.h"
#include "cli/progress.h"
#include "cli/table.h"
#include "ga/checkpoint.h"
#include "reports/study.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "scenarios/files.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

struct ExciteFlags {
  std::string shape = "both";
  double seconds = 20.0, hertz = 3.0;
  double command = std::nan(""), reach = std::nan(""), speed = std::nan("");
  int population = 24, generations = 40;
};

/// Standard error over size from which on a number would say nothing.
constexpr double kUndetermined = 10.0;

std::string summary(const DesignResult& result) {
  std::vector<const Design*> designs{&result.best, &result.step};
  for (const Design& d : result.recordings) designs.push_back(&d);
  TextTable table({"motion", ">log det", ">directions determined"});
  for (const Design* d : designs)
    table.add({d->name, number(d->log_det, 5), fmt::format("{} of {}", d->excitation.rank, d->excitation.parameters)});
  std::string out = table.str() + "\n";
  std::vector<std::string> titles{"expected standard error"};
  for (const Design* d : designs) titles.push_back(">" + d->name);
  TextTable errors(titles);
  for (std::size_t i = 0; i < result.best.excitation.knowledge.size(); ++i) {
    std::vector<std::string> row{result.best.excitation.knowledge[i].name};
    for (const Design* d : designs) {
      const ParameterKnowledge& k = d->excitation.knowledge[i];
      row.push_back(!k.moves                           ? "moves nothing"
                    : k.relative_error < kUndetermined ? percent(k.relative_error)
                                                       : "undetermined");
    }
    errors.add(row);
  }
  for (std::size_t i = 0; i < result.best.excitation.combinations.size(); ++i) {
    std::vector<std::string> row{result.best.excitation.combinations[i].name};
    for (const Design* d : designs) row.push_back(percent(d->excitation.combination_error[i]));
    errors.add(row);
  }
  return out + errors.str();
}

void run(Session& session, const ExciteFlags& flags) {
  DesignOptions options;
  options.shape = shape_from_name(flags.shape);
  const Scenario scenario = load_scenario(session.scenario_file);
  log_notes(scenario);
  const Trial trial = make_trial(scenario, nullptr);
  const MotionLimits limits = motion_limits(trial, flags.command, flags.reach, flags.speed);
  const fs::path folder = session.output_folder(scenario), csv = folder / "excitation.csv";
  for (const RecordingSpec& spec : scenario.recordings) refuse_overwriting(scenario.folder() / spec.file, csv);
  options.seconds = flags.seconds;
  options.hertz = flags.hertz;
  options.population = flags.population;
  options.generations = flags.generations;
  options.seed = session.seed;
  options.threads = session.threads;
  options.control.stop = &stop_flag();
  options.control.checkpoint = folder / "checkpoint.excite.json";
  session.checkpoints.push_back(options.control.checkpoint);
  options.control.problem =
      fingerprint(scenario, {fmt::format("excite {} {} s {} Hz limits {} {} {}", flags.shape, flags.seconds,
                                         flags.hertz, flags.command, flags.reach, flags.speed)});
  DesignResult result;
  {
    ProgressLine line("preparing");
    options.control.progress = line.callback();
    try {
      result = design_excitation(trial, limits, options);
    } catch (const WorkError&) {
      remove_checkpoint(options.control.checkpoint);  // a search that ended without a motion is not taken up again
      throw;
    }
  }
  write_csv(csv, as_recording(trial.scenario, result.best.commands));
  std::vector<std::string> joints, units;
  for (const Joint& joint : trial.model->robot().joints()) {
    units.push_back(trial.model->command_unit(static_cast<int>(joints.size())));
    joints.push_back(joint.name);
  }
  const Context context = session.context();
  const std::string record = to_json(result, scenario.name, "excitation.csv", context);
  write_file_atomically(folder / "excitation.json", record);
  write_file_atomically(folder / "report.html", excitation_page(result, scenario.name, joints, units, context));
  remove_checkpoint(options.control.checkpoint);
  if (session.json) {
    print(record);
    return;
  }
  print(summary(result) +
        fmt::format("\nwritten to {}: excitation.csv, excitation.json, report.html\n", folder.string()));
}

}  // namespace

void add_excite(CLI::App& app, Session& session) {
  auto flags = std::make_shared<ExciteFlags>();
  CLI::App& command = add_scenario_command(
      app, session, "excite",
      "Commands whose motion tells most of the free parameters (D-optimal at the scenario's present values), within "
      "limits\n"
      "of command, position and speed; with the standard errors to expect, beside those of a step and of the "
      "recordings.\n"
      "Writes excitation.csv (a recording's time and command columns), excitation.json and report.html",
      "lacuna excite my_arm/scenario.yaml --seconds 30 --shape multisine -o out/next",
      [&session, flags] { run(session, *flags); });
  command.add_option("--shape", flags->shape, "multisine, staircase or both, one after the other (default: both)");
  command.add_option("--seconds", flags->seconds, "Length (default: 20)")->check(CLI::Range(1.0, 3600.0));
  command.add_option("--hertz", flags->hertz, "Highest frequency (default: 3)")->check(CLI::Range(0.01, 1000.0));
  command.add_option("--command", flags->command, "Largest command, in its own unit (default: the recordings')")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--reach", flags->reach,
                  "Farthest from the start position, rad or m (default: the robot's limits, or what was recorded)")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--speed", flags->speed, "Fastest, rad/s or m/s (default: the robot's limits, or what was recorded)")
      ->check(CLI::PositiveNumber);
  command.add_option("--population", flags->population, "Motions per generation (default: 24)")
      ->check(CLI::Range(5, 100000));
  command.add_option("--generations", flags->generations, "Generations (default: 40)")->check(CLI::Range(1, 1000000));
}

}  // namespace lacuna
