// `lacuna compare`: engines side by side on one scenario, or on every scenario of a folder.
#include "compare/compare.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "cli/command.h"
#include "cli/pictures.h"
#include "cli/progress.h"
#include "cli/scenario_folders.h"
#include "cli/simulators.h"
#include "cli/table.h"
#include "render/snapshot.h"
#include "reports/comparison.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "scenarios/recording_choice.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBaselineBytes = std::uintmax_t{256} << 20;
constexpr int kInstants = 4;                              // of a motion that are drawn
constexpr int kPictureWidth = 400, kPictureHeight = 300;  // pixels, of one of them
constexpr double kShown = 0.3;                            // rad (m): what the largest difference is amplified to

struct CompareFlags {
  std::string engine = "all", recording, baseline;
  double duration = 5.0;  // s
  std::vector<std::string> package_paths;
  bool no_identify = false, no_pictures = false;
  SimulatorFlags simulators;
};

/// Where results go, and what they are called after.
struct Target {
  std::vector<fs::path> files;  ///< scenario files
  fs::path folder;
};

Target target_of(const Session& session) {
  Target out;
  std::error_code ignored;
  const fs::path given = session.scenario_file;
  Scenario named;  // for its name alone
  if (fs::is_directory(given, ignored)) {
    named.name = fs::weakly_canonical(given).filename().string();
    out.folder = session.output_folder(named);
    for (const ScenarioFolder& one : scenario_folders(given, out.folder))
      out.files.push_back(one.folder / "scenario.yaml");
    return out;
  }
  named = load_scenario(given, {.load_recordings = false});
  out.folder = session.output_folder(named);
  out.files.push_back(given);
  return out;
}

/// The scenario with the one recording whose commands are run, or with none.
Scenario loaded(const fs::path& file, const CompareFlags& flags) {
  Scenario scenario = load_scenario(file, {.load_recordings = false});
  if (!flags.recording.empty()) {
    if (scenario.motion) scenario.motion->commands.clear();
    return with_recording(scenario, recording_named(scenario, flags.recording));
  }
  if (scenario.motion && !scenario.motion->commands.empty()) scenario.recordings.clear();
  if (scenario.recordings.empty()) return scenario;
  const auto test = std::find_if(scenario.recordings.begin(), scenario.recordings.end(),
                                 [](const RecordingSpec& spec) { return spec.role == Role::test; });
  return with_recording(scenario, test == scenario.recordings.end() ? scenario.recordings.front() : *test);
}

/// Position of a joint at a sample; NaN where the run did not come so far.
double position(const EngineRun& run, std::size_t sample, std::size_t joint) {
  return sample < run.run.q.size() ? run.run.q[sample][joint] : std::nan("");
}

/// Largest distance of a joint from the referee at the instants drawn, finite ones only.
double largest_difference(const std::vector<EngineRun>& runs, const std::vector<std::size_t>& instants) {
  double out = 0.0;
  for (const EngineRun& run : runs) {
    for (const std::size_t k : instants) {
      for (std::size_t j = 0; j < runs.front().run.q[k].size(); ++j) {
        const double off = std::fabs(position(run, k, j) - runs.front().run.q[k][j]);
        if (std::isfinite(off)) out = std::max(out, off);
      }
    }
  }
  return out;
}

/// Rows: engines; columns: instants. Where `factor` is not 1, poses are the referee's plus `factor` times the
/// difference.
Image sheet(const Scenario& scenario, const std::vector<EngineRun>& runs, const std::vector<std::size_t>& instants,
            double factor) {
  std::vector<Drawing> drawings;
  for (std::size_t r = 1; r < runs.size(); ++r) {
    for (const std::size_t k : instants) {
      std::vector<double> q = runs.front().run.q[k];
      for (std::size_t j = 0; j < q.size(); ++j) q[j] += factor * (position(runs[r], k, j) - q[j]);
      drawings.push_back({runs[r].engine, q, fmt::format("{}, {}", runs[r].engine, runs[r].method),
                          fmt::format("t = {:.3g} s{}", runs[r].times[k],
                                      factor == 1.0 ? "" : fmt::format(", difference x {:g}", factor))});
    }
  }
  PoseOptions options;
  options.width = kPictureWidth;
  options.height = kPictureHeight;
  return contact_sheet(draw(scenario, drawings, options), static_cast<int>(instants.size()));
}

/// Contact sheets of the engines' own runs: as they are, and with their differences from the referee amplified.
std::vector<Picture> motion_pictures(const fs::path& folder, const Scenario& scenario,
                                     const std::vector<EngineRun>& runs) {
  if (std::string reason; !render_available(&reason)) {
    spdlog::info("no pictures: {}", reason);
    return {};
  }
  if (runs.size() < 2) return {};
  std::vector<std::size_t> instants;
  for (int i = 1; i <= kInstants; ++i)
    instants.push_back((runs.front().times.size() - 1) * static_cast<std::size_t>(i) / kInstants);
  std::vector<Picture> out;
  const auto add = [&](const std::string& name, const std::string& title, double factor) {
    const Image image = sheet(scenario, runs, instants, factor);
    write_png(folder / name, image);
    out.push_back({title, encode_png(image)});
  };
  add("poses.png", scenario.name + ": every engine's own motion", 1.0);
  const double largest = largest_difference(runs, instants);
  if (largest > 0.0) {
    const double factor = std::max(1.0, std::pow(10.0, std::floor(std::log10(kShown / largest))));
    add("differences.png", fmt::format("{}: differences from the referee, amplified {:g} times", scenario.name, factor),
        factor);
  }
  return out;
}

std::string summary(const Comparison& comparison) {
  std::string out;
  for (const ScenarioComparison& scenario : comparison.scenarios) {
    out += fmt::format("{}: {} joints, {}, step {}\n", printable(scenario.name), scenario.dof, scenario.motion,
                       quantity(1e3 * scenario.step, "ms", 3));
    TextTable table({"engine", ">acceleration difference", ">trajectory error", ">energy drift", ">ns per step",
                     ">real-time factor", ">ns per evaluation"});
    std::string refused;
    for (const EngineComparison& engine : scenario.engines) {
      if (!engine.available) {
        refused += engine.reason + "\n";
        continue;
      }
      const MethodResult& common = engine.method(kCommonMethod);
      table.add({engine.engine, number(engine.acceleration_difference.value, 2), number(common.trajectory_error, 3),
                 number(common.energy_drift, 2), steady(common.ns_per_step.median), steady(common.realtime_factor),
                 steady(engine.forward_ns.median)});
    }
    out += table.str() + refused + "\n";
  }
  for (const Recommendation& verdict : recommendations(comparison))
    out += verdict.need + ": " + list_of(verdict.best) + "\n";
  return out;
}

std::string changes_words(const Baseline& baseline) {
  if (baseline.empty()) return "";
  std::string out = fmt::format("\n{} of {} figures changed beyond noise since {}\n", baseline.changes.size(),
                                baseline.compared, baseline.date);
  TextTable table({"scenario", "engine", "quantity", ">before", ">now", ""});
  for (const Change& change : baseline.changes)
    table.add({change.scenario, change.engine, change.quantity, number(change.before), number(change.after),
               change.better ? "better" : "worse"});
  return table.empty() ? out : out + table.str();
}

/// Drawn is the first scenario with an arm's number of joints: one sheet says what all would.
bool worth_drawing(const Scenario& scenario) { return scenario.robot->dof() >= 4 && scenario.robot->dof() <= 12; }

class CompareRun {
 public:
  CompareRun(const Session& session, const CompareFlags& flags) : session_(session), flags_(flags) {
    options_.engines = engines_named(flags.engine);
    options_.duration = flags.duration;
    options_.identify = !flags.no_identify;
    options_.seed = session.seed;
    options_.threads = session.threads;
    options_.stop = &stop_flag();
    if (!flags.baseline.empty())
      old_ = read_text_file(flags.baseline, flags.baseline, "a compare.json", kMostBaselineBytes);
    if (!flags.baseline.empty()) changes_since(old_, flags.baseline, {});  // refuses another file before the work
    for (const Engine* engine : engines()) comparison_.engines.push_back(engine->info());
    target_ = target_of(session);
    refuse_overwritten_baseline();
  }

  void run() {
    const auto begun = std::chrono::steady_clock::now();
    {
      ProgressLine progress("preparing");
      for (std::size_t i = 0; i < target_.files.size(); ++i) {
        options_.progress = [&](const std::string& stage, double done) {
          progress.update(stage, (static_cast<double>(i) + done) / static_cast<double>(target_.files.size()));
        };
        compare(target_.files[i], i + 1 == target_.files.size());
        comparison_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        write();  // what is done is not lost with what follows
      }
    }
    if (session_.json) {
      print(to_json(comparison_, baseline_, context_));
      return;
    }
    std::vector<std::string> written{"report.html", "compare.json"};
    if (!pictures_.empty()) written.insert(written.end(), {"poses.png", "differences.png"});
    written.resize(2 + pictures_.size());
    print(summary(comparison_) + changes_words(baseline_) + "\nwritten to " + target_.folder.string() + ": " +
          list_of(written) + "\n");
  }

 private:
  void refuse_overwritten_baseline() const {
    if (!flags_.baseline.empty()) refuse_overwriting(flags_.baseline, target_.folder / "compare.json");
  }

  void compare(const fs::path& file, bool last) {
    Scenario scenario = loaded(file, flags_);
    if (!flags_.no_pictures) load_meshes(scenario, flags_.package_paths);
    log_notes(scenario);
    const bool drawn = !flags_.no_pictures && pictures_.empty() && (last || worth_drawing(scenario));
    std::vector<EngineRun> runs;
    comparison_.scenarios.push_back(compare_engines(scenario, options_, drawn ? &runs : nullptr));
    if (drawn) pictures_ = motion_pictures(target_.folder, scenario, runs);
  }

  void write() {
    if (!old_.empty()) baseline_ = changes_since(old_, flags_.baseline, comparison_);
    write_comparison_report(target_.folder, comparison_, baseline_, context_, pictures_);
  }

  const Session& session_;
  Context context_ = session_.context();  ///< one date for all that is written and printed
  const CompareFlags& flags_;
  CompareOptions options_;
  Target target_;
  std::string old_;
  Comparison comparison_;
  Baseline baseline_;
  std::vector<Picture> pictures_;
};

}  // namespace

void add_compare(CLI::App& app, Session& session) {
  auto flags = std::make_shared<CompareFlags>();
  CLI::App& command = add_scenario_command(
      app, session, "compare",
      "Engines side by side: agreement, accuracy against a converged reference, energy and momentum, cost, work "
      "against\n"
      "precision, repeatability, identification. SCENARIO may be a folder of scenarios: one report over all.\n"
      "Writes compare.json, report.html and pictures to -o DIR, else out/<name>",
      "lacuna compare scenarios/compare -o out/compare", [&session, flags] {
        if (!flags->simulators.engines.empty()) return run_simulators(session, flags->simulators);
        CompareRun(session, *flags).run();
      });
  command.add_option("--engine", flags->engine, "Engines, with commas between them, or all (default: all)");
  command.add_option("--recording", flags->recording,
                     "Recording whose commands and start are run (default: the first test recording)");
  command.add_option("--duration", flags->duration, "Longest motion where the scenario states none, s (default: 5)")
      ->check(CLI::Range(0.05, 1000.0));
  command.add_option("--baseline", flags->baseline, "An older compare.json: what changed beyond noise is marked");
  add_package_paths(command, flags->package_paths);
  command.add_flag("--no-identify", flags->no_identify, "Leaves out the identification on every engine");
  add_simulator_options(command, flags->simulators);
  command.add_flag("--no-pictures", flags->no_pictures, "Leaves out the pose snapshots");
}

}  // namespace lacuna
