// `lacuna diff`: two sets of recordings of one machine; what changed between them.
#include "diff/diff.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cli/diagnose_run.h"
#include "cli/files.h"
#include "cli/pictures.h"
#include "cli/progress.h"
#include "cli/recording_sets.h"
#include "cli/table.h"
#include "diagnosis/checkpoint.h"
#include "reports/diff.h"
#include "reports/report.h"
#include "reports/wording.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

struct DiffFlags {
  std::string a, b, scenario;
  DiagnoseFlags diagnose;
};

constexpr double kDiagnosisPart = 0.42;  ///< of the progress: what one diagnosis takes

std::pair<Scenario, Scenario> load_sets(const DiffFlags& flags) {
  if (flags.scenario.empty()) {
    Scenario a = load_scenario(flags.a), b = load_scenario(flags.b);
    check_comparable(a, b);
    return {std::move(a), std::move(b)};
  }
  const Scenario model = load_scenario(flags.scenario, {.load_recordings = false});
  return {with_recording_set(model, flags.a, "A"), with_recording_set(model, flags.b, "B")};
}

/// -o, else out/<A>-<B>; its two folders for the sets' own diagnoses, created.
fs::path folder_for(const Session& session, const Scenario& a, const Scenario& b) {
  Scenario named = a;
  named.name = a.name + "-" + b.name;
  const fs::path out = session.output_folder(named);
  for (const char* set : {"a", "b"}) make_parent_folder(out / set / "diagnosis.json");
  return out;
}

/// One set's diagnosis, its own report written at once: killed later, that is not lost.
Diagnosis diagnosed(Session& session, const DiffFlags& flags, const Scenario& scenario, const fs::path& folder,
                    const std::string& label, double done, ProgressLine& progress) {
  const Diagnosis out = run_diagnosis(session, flags.diagnose, scenario, folder, [&](const Progress& p) {
    progress.update(label + ": " + p.stage, done + kDiagnosisPart * p.done);
  });
  if (session.first()) write_diagnosis_report(folder, scenario, out, session.context(), {});
  return out;
}

Diff compared(Session& session, const DiffFlags& flags, const Scenario& a, const Scenario& b, const fs::path& folder) {
  ProgressLine progress("preparing");
  const Diagnosis of_a = diagnosed(session, flags, a, folder / "a", "A", 0.0, progress);
  const Diagnosis of_b = diagnosed(session, flags, b, folder / "b", "B", kDiagnosisPart, progress);
  session.checkpoints = {folder / "a" / "checkpoint.json", folder / "b" / "checkpoint.json"};
  IdentifyOptions options = flags.diagnose.identify.understood(session, engine_named(flags.diagnose.identify.engine));
  options.control.progress = [&](const Progress& p) {
    progress.update(p.stage, 2.0 * kDiagnosisPart + (1.0 - 2.0 * kDiagnosisPart) * p.done);
  };
  return compare_sets(a, of_a, b, of_b, options);
}

std::string summary(const Scenario& scenario, const Diff& diff) {
  std::string out = wrapped(diff_sentence(diff), 110, 0) + "\n\n";
  TextTable changes({"what", "where", ">probability", "number", ">A", ">B", ">difference", "may as well be"});
  for (const MachineChange& c : diff.changes) {
    std::vector<std::string> others(c.members.begin() + 1, c.members.end());
    others.insert(others.end(), c.look_alikes.begin(), c.look_alikes.end());
    for (const ChangedNumber& n : c.numbers)
      changes.add({c.effect.empty() ? n.key : c.effect, c.place, probability(c.class_probability), n.key,
                   number_words(n.a), number_words(n.b), number_words(n.difference), list_of(others)});
  }
  if (!changes.empty()) out += changes.str() + "\n";
  for (const RefusedChange& r : diff.refused)
    out += fmt::format("not claimed: {} (probability {}): {}\n", r.name, probability(r.probability), r.reason);
  TextTable rms({"rms of B", "recordings", ">model of A", ">model of B", ">shared and changed", "unit"});
  const Role last = diff.b.fit.empty() ? Role::train : diff.b.fit.back().role;
  for (const DiffFit& f : diff.b.fit) {
    if (f.role != last) continue;
    for (const auto& [joint, value] : f.joint)
      rms.add({joint, to_string(f.role), steady(entry_of(f.of_a, joint)), steady(entry_of(f.of_b, joint)),
               steady(value), residual_unit(scenario, nullptr, joint)});
  }
  out += rms.str();
  for (const std::string& note : diff.notes) out += wrapped("note: " + note, 110, 2) + "\n";
  return out;
}

void run(Session& session, const DiffFlags& flags) {
  engine_named(flags.diagnose.identify.engine);
  flags.diagnose.identify.understood(session, flags.diagnose.identify.engine);  // refuses unknown names at once
  auto sets = load_sets(flags);
  for (Scenario* set : {&sets.first, &sets.second}) load_meshes(*set, flags.diagnose.identify.package_paths);
  const auto& [a, b] = sets;
  check_diagnosable(a), check_diagnosable(b);
  log_notes(a), log_notes(b);
  const fs::path folder = folder_for(session, a, b);
  const Diff diff = compared(session, flags, a, b, folder);
  if (!session.first()) return;
  const Context context = session.context();
  write_diff_report(folder, a, diff, context);
  for (const char* set : {"a", "b"}) DiagnosisCheckpoint::remove(folder / set / "checkpoint.json");
  if (session.json) {
    print(to_json(diff, context) + "\n");
    return;
  }
  print(summary(a, diff) +
        fmt::format("\n{}; written to {}: diff.json, report.html, and each set's diagnosis in a/ and "
                    "b/\n",
                    duration(diff.seconds), folder.string()));
}

}  // namespace

void add_diff(CLI::App& app, Session& session) {
  auto flags = std::make_shared<DiffFlags>();
  flags->diagnose.no_engines = true;
  CLI::App& command = add_command(
      app, session, "diff",
      "Two sets of recordings of one machine (before and after, unit 1 and unit 2): what they have in common, what\n"
      "changed, where, with which probability. A and B are scenarios that differ in their recordings alone, or, with\n"
      "--scenario, recordings that are read with that scenario's channels and model: a folder (its .csv, .mat, .db3\n"
      "and .mcap files and bags, by name), one file, a .txt list of files, or several of these with commas. Of three\n"
      "files or more the last is test, the one before it validate, the others train; of two the second is halved into\n"
      "validate and test; a lone one is cut at 60 and 80 % of its time into train, validate and test.\n"
      "Writes diff.json, report.html, and each set's diagnosis below a/ and b/, to -o DIR, else out/<A>-<B>;\n"
      "interrupted, the same command resumes",
      "lacuna diff before/scenario.yaml after/scenario.yaml -o out/repair\n"
      "  lacuna diff unit_1/ unit_2/ --scenario arm/scenario.yaml",
      [&session, flags] { run(session, *flags); });
  command.add_option("A", flags->a, "The first set: scenario.yaml, or with --scenario recordings")
      ->required()
      ->option_text(" ");
  command.add_option("B", flags->b, "The second set, likewise")->required()->option_text(" ");
  command.add_option("--scenario", flags->scenario, "Scenario whose model and channels both sets are read with");
  constexpr int kGenerations = 20;  // as diagnose
  flags->diagnose.identify.generations = kGenerations;
  flags->diagnose.identify.no_pictures = true;
  flags->diagnose.identify.add_to(command, false);
}

}  // namespace lacuna
