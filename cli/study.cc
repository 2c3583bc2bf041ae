// `lacuna study`: the seed paper's experiments on its genetic algorithm, redone over many seeds, and what it is worth.
#include "study/study.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
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

struct StudyFlags {
  std::vector<std::string> scenarios, parts;
  std::string truth;
  int seeds = 5, population = 70, generations = 200, engine_generations = 10;
};

/// A scenario with what is known of its truth.
struct Case {
  Scenario scenario;
  std::optional<Scenario> truth;
};

Case load_case(const std::string& file, const StudyFlags& flags) {
  Case out{load_scenario(file), std::nullopt};
  log_notes(out.scenario);
  std::optional<fs::path> truth = find_truth(out.scenario);
  if (!flags.truth.empty()) truth = flags.truth;
  if (truth) out.truth = load_scenario(*truth, {.load_recordings = false});
  return out;
}

std::vector<Case> load_cases(const StudyFlags& flags) {
  if (!flags.truth.empty() && flags.scenarios.size() > 1)
    throw InputError("--truth", std::to_string(flags.scenarios.size()) + " scenarios", "one scenario with --truth");
  std::vector<Case> out;
  for (const std::string& file : flags.scenarios) {
    out.push_back(load_case(file, flags));
    for (std::size_t k = 0; k + 1 < out.size(); ++k) {
      if (out[k].scenario.name == out.back().scenario.name)
        throw InputError(file, "the name " + quoted(out[k].scenario.name) + " again", "scenarios of different names");
    }
  }
  return out;
}

std::string summary(const Study& study) {
  std::string out = fmt::format("{}: {} evaluations\n\n", study.scenario, study.evaluations);
  TextTable claims({"the paper's claim", "", "here"});
  for (const Conclusion& c : study.conclusions) claims.add({c.claim, c.source, to_string(c.verdict)});
  if (!claims.empty()) out += claims.str() + "\n";
  TextTable rivals({fmt::format("{} evaluations", study.rivals.budget), ">within 1 %", ">within 10 %", ">within twice",
                    ">median evaluations to 1 %"});
  for (const MethodRecord& m : study.rivals.methods)
    rivals.add({title_of(m.method), percent(m.success[0]), percent(m.success[1]), percent(m.success[2]),
                number(quartiles_of(m.reached[0]).median, 3)});
  if (!rivals.empty()) out += rivals.str() + study.rivals.reason + "\n\n";
  TextTable known({"excitation", "assumed", ">directions determined"});
  for (const Excitation& e : study.identifiability)
    known.add({e.name, e.assumption, fmt::format("{} of {}", e.rank, e.parameters)});
  if (!known.empty()) out += known.str() + "\n";
  if (study.recovery.asked > 0)
    out += fmt::format("95 % intervals that hold the truth: {} of {}\n\n", study.recovery.held, study.recovery.asked);
  for (const SkippedPart& p : study.skipped) out += fmt::format("left out: {} ({})\n", p.part, p.reason);
  return out;
}

StudyOptions options_of(const Session& session, const StudyFlags& flags) {
  StudyOptions out;
  out.seeds = flags.seeds;
  out.seed = session.seed;
  out.population = flags.population;
  out.generations = flags.generations;
  out.engine_generations = flags.engine_generations;
  out.parts = flags.parts;
  out.runner.threads = session.threads;
  out.runner.stop = &stop_flag();
  out.runner.ranks = session.ranks.get();
  return out;
}

std::vector<Study> run_all(Session& session, const StudyFlags& flags, const std::vector<Case>& cases,
                           const fs::path& folder) {
  std::vector<Study> out;
  ProgressLine line("preparing");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& one = cases[i];
    StudyOptions options = options_of(session, flags);
    options.runner.checkpoint = folder / fmt::format("checkpoint.{}.jsonl", file_name(one.scenario.name));
    session.checkpoints.push_back(options.runner.checkpoint);
    // Not the number of seeds, nor the parts: their runs are the same in a larger study.
    options.runner.problem =
        fingerprint(one.scenario, {fmt::format("study seed {} population {} generations {} {} truth {}", session.seed,
                                               flags.population, flags.generations, flags.engine_generations,
                                               one.truth ? fingerprint(*one.truth, {}) : "unknown")});
    options.runner.progress = [&](const Progress& p) {
      line.update(fmt::format("{}: {}", one.scenario.name, p.stage),
                  (static_cast<double>(i) + p.done) / static_cast<double>(cases.size()));
    };
    out.push_back(run_study(one.scenario, one.truth ? &*one.truth : nullptr, options));
  }
  return out;
}

void run(Session& session, const StudyFlags& flags) {
  const std::vector<Case> cases = load_cases(flags);
  const fs::path folder = session.output_folder(cases.front().scenario);
  const std::vector<Study> studies = run_all(session, flags, cases, folder);
  if (!session.first()) return;
  const Context context = session.context();
  const std::string record = to_json(studies, context);
  write_file_atomically(folder / "study.json", record);
  write_file_atomically(folder / "report.html", study_page(studies, context));
  for (const fs::path& checkpoint : session.checkpoints) remove_checkpoint(checkpoint);
  if (session.json) {
    print(record);
    return;
  }
  std::string out;
  for (const Study& study : studies) out += summary(study) + "\n";
  print(out + fmt::format("written to {}: study.json, report.html\n", folder.string()));
}

}  // namespace

void add_study(CLI::App& app, Session& session) {
  auto flags = std::make_shared<StudyFlags>();
  CLI::App& command = add_command(
      app, session, "study",
      "The genetic algorithm's paper redone over many seeds, and what it is worth: its settings one by one, what the "
      "data\n"
      "determine at all, other optimisers on the same budget, bad data and bounds. Writes study.json and report.html "
      "to\n"
      "-o DIR, else out/<name>; interrupted, the same command resumes",
      "lacuna study scenarios/hydrolek/joint_2_table1.yaml scenarios/hydrolek/joint_2_table5.yaml "
      "scenarios/hydrolek/scenario.yaml",
      [&session, flags] { run(session, *flags); });
  command.add_option("SCENARIO", flags->scenarios, "One or more scenario files")->required()->option_text(" ");
  command.add_option("--seeds", flags->seeds, "Runs of every setting (default: 5)")->check(CLI::Range(1, 10000));
  command.add_option("--population", flags->population, "Parameter sets per generation (default: 70)")
      ->check(CLI::Range(14, 100000));
  command.add_option("--generations", flags->generations, "Generations (default: 200)")->check(CLI::Range(1, 1000000));
  command
      .add_option("--engine-generations", flags->engine_generations,
                  "Generations where all engines run side by side (default: 10)")
      ->check(CLI::Range(1, 1000000));
  command
      .add_option("--parts", flags->parts,
                  fmt::format("Some of {} (default: what suits the scenario)", fmt::join(study_parts(), ", ")))
      ->delimiter(',');
  command.add_option(
      "--truth", flags->truth,
      "A scenario whose values are the true ones (default: truth.yaml beside the first train recording)");
}

}  // namespace lacuna
