// `lacuna blind`: every case below a folder diagnosed, and only then the labels opened and the verdicts scored.
#include "reports/blind.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "cli/diagnose_run.h"
#include "cli/pictures.h"
#include "cli/progress.h"
#include "cli/scenario_folders.h"
#include "cli/table.h"
#include "diagnosis/checkpoint.h"
#include "reports/report.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/sha256.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

struct BlindFlags {
  DiagnoseFlags diagnose;
  std::string folder;
  bool quick = false;
};

constexpr std::size_t kQuickCases = 4;
constexpr int kQuickPopulation = 20, kQuickGenerations = 5;
constexpr std::uintmax_t kMostLabelBytes = std::uintmax_t{16} << 20, kMostRecordBytes = std::uintmax_t{256} << 20;

/// A fixed slice, evenly spread over the names: what is in the cases is not known here.
std::vector<ScenarioFolder> slice(const std::vector<ScenarioFolder>& cases) {
  if (cases.size() <= kQuickCases) return cases;
  std::vector<ScenarioFolder> out;
  for (std::size_t k = 0; k < kQuickCases; ++k) out.push_back(cases[k * cases.size() / kQuickCases]);
  return out;
}

/// What a verdict rests on: the case's files, the options, the program.
std::string key_of(const Session& session, const DiagnoseFlags& flags, const Scenario& scenario) {
  return fmt::format("{} engines {} commit {}\n", diagnosis_fingerprint(session, flags, scenario),
                     flags.no_engines ? "one" : "all", session.context().commit);
}

std::string text_if_there(const fs::path& file, std::uintmax_t most) {
  std::error_code ignored;
  return fs::exists(file, ignored) ? read_text_file(file, file.string(), "a text file", most) : std::string();
}

/// The verdict of an earlier run on the same data by the same program; else nothing.
std::optional<BlindVerdict> finished(const fs::path& folder, const std::string& key) {
  try {
    if (text_if_there(folder / "input.txt", kMostLabelBytes) != key) return std::nullopt;
    const fs::path file = folder / "diagnosis.json";
    return read_verdict(text_if_there(file, kMostRecordBytes), file.string());
  } catch (const InputError&) {
    return std::nullopt;  // cut off or of another format: it is made anew
  }
}

/// The verdict on one case, from `folder` or made now; nothing where another rank writes it. The label is not looked
/// at.
std::optional<BlindVerdict> verdict_on(Session& session, const DiagnoseFlags& flags, const ScenarioFolder& one,
                                       const fs::path& folder, const std::function<void(const Progress&)>& progress) {
  Scenario scenario = load_scenario(one.folder / "scenario.yaml");
  load_meshes(scenario, flags.identify.package_paths);
  check_diagnosable(scenario);
  const std::string key = key_of(session, flags, scenario);
  const auto verdict = session.first() ? finished(folder, key) : std::nullopt;
  if (verdict) DiagnosisCheckpoint::remove(folder / "checkpoint.json");  // a kill may have come just before that
  if (session.ranks ? session.ranks->as_first(verdict.has_value()) : verdict.has_value()) return verdict;
  make_parent_folder(folder / "diagnosis.json");
  const Diagnosis diagnosis = run_diagnosis(session, flags, scenario, folder, progress);
  if (!session.first()) return std::nullopt;
  fs::remove(folder / "input.txt");  // until the verdict is whole, it is nobody's
  write_diagnosis_report(folder, scenario, diagnosis, session.context(), {});
  write_file_atomically(folder / "input.txt", key);
  DiagnosisCheckpoint::remove(folder / "checkpoint.json");
  const fs::path file = folder / "diagnosis.json";
  return read_verdict(text_if_there(file, kMostRecordBytes), file.string());
}

std::vector<BlindCase> give_verdicts(Session& session, const DiagnoseFlags& flags,
                                     const std::vector<ScenarioFolder>& cases, const fs::path& out) {
  std::vector<BlindCase> verdicts;
  std::vector<fs::path> done;
  ProgressLine line("preparing");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto progress = [&](const Progress& p) {
      line.update(fmt::format("case {} of {}, {}: {}", i + 1, cases.size(), printable(cases[i].name, 40), p.stage),
                  (static_cast<double>(i) + p.done) / static_cast<double>(cases.size()));
    };
    progress({"starting", 0.0, 0.0, 0});
    BlindCase one;
    one.name = cases[i].name;
    try {
      if (stop_flag()) throw Interrupted();
      one.verdict = verdict_on(session, flags, cases[i], out / fs::path(cases[i].name), progress);
      done.push_back(out / fs::path(cases[i].name) / "diagnosis.json");
    } catch (const Interrupted&) {
      session.checkpoints.insert(session.checkpoints.end(), done.begin(), done.end());
      throw;
    } catch (const WriteError&) {
      throw;  // the next case could not be written either
    } catch (const std::exception& error) {
      one.error = error.what();
      spdlog::warn("{}: {}", printable(one.name), printable(one.error, 500));
    }
    verdicts.push_back(std::move(one));
  }
  return verdicts;
}

/// Opens the label, if there is one, and holds it against its seal.
void open_label(const ScenarioFolder& where, BlindCase& one) {
  const std::string text = text_if_there(where.folder / "label.json", kMostLabelBytes);
  if (text.empty()) return;
  const std::string sealed = text_if_there(where.folder / "label.sha256", 4096);
  if (!sealed.empty()) one.seal = sealed.substr(0, 64) == sha256(text) ? Seal::intact : Seal::broken;
  one.label = read_label(text, (where.folder / "label.json").string());
}

std::string by_condition(const std::vector<BlindCase>& cases) {
  TextTable table(
      {"condition", ">cases", ">right", ">false alarms", ">place", ">class", ">mean F1", ">true above 0.9"});
  const auto share = [](const Rate& rate) { return rate.of > 0 ? fmt::format("{} of {}", rate.hits, rate.of) : ""; };
  for (const auto& [name, t] : totals_by_condition(cases))
    table.add({printable(name, 40), std::to_string(t.cases), share(t.correct), share(t.null_false_alarms),
               share(t.location_top1), share(t.class_top1), t.several > 0 ? number(t.set_f1, 3) : "",
               share(t.claims_above_09)});
  return table.empty() ? "" : "\n" + table.str();
}

std::string summary(const std::vector<BlindCase>& cases, const BlindTotals& t) {
  TextTable table({"case", "verdict", "findings", "right"});
  for (const BlindCase& one : cases) {
    std::vector<std::string> findings;
    if (one.verdict)
      for (const auto& claim : one.verdict->claims) findings.push_back(claim.effect + " at " + claim.place);
    const bool scored = one.label && one.seal != Seal::broken;
    table.add({printable(one.name, 60), one.verdict ? one.verdict->verdict : "failed", list_of(findings),
               !scored                   ? "no label"
               : score_case(one).correct ? "yes"
                                         : "no"});
  }
  std::string out = table.str() + "\n";
  const auto add = [&](const char* words, const Rate& rate) {
    if (rate.of > 0) out += fmt::format("{}: {} of {}\n", words, rate.hits, rate.of);
  };
  add("false alarms", t.null_false_alarms);
  add("place right", t.location_top1);
  add("class right", t.class_top1);
  add("outside the catalogue, called unknown", t.abstained_correctly);
  add("  joint of what was learned right", t.laws.place);
  add("  and the stage", t.laws.stage);
  add("  and the variables", t.laws.over);
  if (t.laws.curves > 0)
    out += fmt::format("  median error of the curve: {} ({} of {} learned)\n", number(t.laws.median_error(), 2),
                       t.laws.curve_errors.size(), t.laws.curves);
  add("  events found", t.laws.events);
  add("  rest at the noise", t.laws.at_noise);
  add("laws or events learned where nothing was hidden", t.false_laws_null);
  add("laws or events learned where the catalogue has all", t.false_laws_exact);
  add("claims above 0.9 that are true", t.claims_above_09);
  if (t.several > 0) out += fmt::format("several effects, mean F1: {}\n", number(t.set_f1, 3));
  if (t.shared > 0) out += fmt::format("share of the oracle's held-out gain: {}\n", percent(t.heldout_gain_share));
  return out + by_condition(cases);
}

/// After everything is written: what the user must not overlook.
void complain(const std::vector<ScenarioFolder>& folders, const std::vector<BlindCase>& cases) {
  for (std::size_t i = 0; i < cases.size(); ++i)
    if (cases[i].seal == Seal::broken)
      throw InputError((folders[i].folder / "label.json").string(), "a label that does not match its seal",
                       "the SHA-256 in label.sha256");
  if (std::none_of(cases.begin(), cases.end(), [](const BlindCase& one) { return one.verdict.has_value(); }))
    throw WorkError("no case could be diagnosed; the first: " + cases.front().error);
}

void run(Session& session, const BlindFlags& given) {
  BlindFlags flags = given;
  if (flags.quick) {
    flags.diagnose.identify.population = std::min(flags.diagnose.identify.population, kQuickPopulation);
    flags.diagnose.identify.generations = std::min(flags.diagnose.identify.generations, kQuickGenerations);
    flags.diagnose.no_engines = true;
  }
  engine_named(flags.diagnose.identify.engine);
  flags.diagnose.identify.understood(session, flags.diagnose.identify.engine);  // refuses unknown names at once
  const fs::path out = session.output.empty() ? fs::path("out/blind") : fs::path(session.output);
  std::vector<ScenarioFolder> folders = scenario_folders(flags.folder, out);
  if (flags.quick) folders = slice(folders);
  make_parent_folder(out / "blind.json");
  std::vector<BlindCase> cases = give_verdicts(session, flags.diagnose, folders, out);
  if (!session.first()) return;
  // Every verdict is on disk. From here on, and nowhere before, labels are read.
  for (std::size_t i = 0; i < cases.size(); ++i) open_label(folders[i], cases[i]);
  const Context context = session.context();
  const std::string record = to_json(cases, context);
  write_file_atomically(out / "blind.json", record);
  write_file_atomically(out / "report.html",
                        blind_page(cases, fs::path(flags.folder).lexically_normal().string(), context));
  if (session.json) {
    print(record);
  } else {
    print(summary(cases, total(cases)) + fmt::format("\nwritten to {}: blind.json, report.html\n", out.string()));
  }
  complain(folders, cases);
}

}  // namespace

void add_blind(CLI::App& app, Session& session) {
  auto flags = std::make_shared<BlindFlags>();
  CLI::App& command = add_command(
      app, session, "blind",
      "Diagnoses every case folder below DIR without opening any label; then, and only then, opens the labels that "
      "are\n"
      "there, checks their seals and scores. Writes <case>/diagnosis.json, blind.json and report.html to -o DIR, else\n"
      "out/blind; interrupted, the same command resumes",
      "lacuna blind cases -o out/blind", [&session, flags] { run(session, *flags); });
  command.add_option("DIR", flags->folder, "Folder with cases below it, each with a scenario.yaml")
      ->required()
      ->option_text(" ");
  flags->diagnose.add_to(command);
  command.add_flag("--quick", flags->quick,
                   fmt::format("{} cases, evenly spread over their names, with a small search", kQuickCases));
}

}  // namespace lacuna
