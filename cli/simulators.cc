#include "cli/simulators.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "cli/diagnose_run.h"
#include "cli/progress.h"
#include "cli/table.h"
#include "diagnosis/checkpoint.h"
#include "diagnosis/diagnosis.h"
#include "ga/random.h"
#include "reports/report.h"
#include "reports/simulators.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "scenarios/recording_choice.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/text.h"
#include "compare/motion.h"
#include "compare/simulators.h"

namespace lacuna {
namespace {

namespace fs = std::filesystem;

constexpr double kNoiseShare = 1e-4;       // of a joint's travel, where the scenario states no noise
constexpr std::uint32_t kNoiseDraws = 81;  // purpose of the random streams
constexpr int kSteps = 3;                  // h, h/2, h/4

/// A's runs over one recording.
struct Recorded {
  std::string file;  ///< of the scenario
  Scenario alone;    ///< with this recording only
  std::vector<Trajectory> runs;
};

std::pair<std::string, std::string> two_engines(const std::string& text) {
  const std::vector<std::string> names = engines_named(text == "all" ? "all," : text);
  if (names.size() != 2) throw InputError("--simulators", quoted(text), "two engines with a comma between them");
  if (find_engine(names[0]).info().own_losses) return {names[0], names[1]};
  std::vector<std::string> able;
  for (const Engine* engine : engines())
    if (engine->info().own_losses) able.push_back(engine->info().name);
  throw WorkError("engine " + names[0] + " has no damping and friction of its own in its steps; " +
                  (able.empty() ? "no engine of this build has" : "these have: " + list_of(able)));
}

NativeMethod method_of(const std::string& engine, const std::string& integrator) {
  const std::vector<std::string> known = find_engine(engine).info().native_integrators;
  if (integrator.empty()) return {engine, known.front()};
  if (std::ranges::find(known, integrator) == known.end())
    throw InputError("--integrator", quoted(integrator), one_of(known));
  return {engine, integrator};
}

std::vector<Recorded> record(const Scenario& scenario, const NativePlant& plant, const NativeMethod& method,
                             double step, ProgressLine& progress) {
  std::vector<Recorded> out;
  for (const RecordingSpec& spec : recordings_of(scenario)) {
    Recorded one{spec.file, with_recording(scenario, spec), {}};
    for (int k = 0; k < kSteps; ++k) {
      progress.update("recording " + printable(spec.file, 40), 0.02);
      if (stop_flag().load()) throw Interrupted();
      one.runs.push_back(record_natively(plant, one.alone, method, step / std::exp2(k)));
    }
    out.push_back(std::move(one));
  }
  return out;
}

/// Of every joint: as the scenario states it, else a share of the joint's travel in all recordings.
std::vector<double> noise_of(const Scenario& scenario, const std::vector<Recorded>& recorded) {
  std::vector<double> out;
  const auto stated = scenario.noise.find(ChannelKind::position);
  for (std::size_t j = 0; j < scenario.robot->joints().size(); ++j) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Recorded& one : recorded)
      for (const std::vector<double>& q : one.runs.front().q) low = std::min(low, q[j]), high = std::max(high, q[j]);
    out.push_back(std::max(kNoiseShare * (high - low), 1e-9));
    if (stated == scenario.noise.end()) continue;
    const auto at = stated->second.find(scenario.robot->joints()[j].name);
    if (at != stated->second.end()) out.back() = at->second;
  }
  return out;
}

/// Clock, commands and noisy positions; the noise is the same whatever the step.
Recording recording_of(const Scenario& alone, const Trajectory& run, const std::vector<double>& noise,
                       std::uint64_t seed, std::uint32_t index) {
  RecordingSpec whole = alone.recordings.front();
  whole.from.reset(), whole.to.reset();
  const auto track = command_track(alone, whole);
  Recording out;
  out.names = {"t"}, out.columns = {track->time};
  const auto& joints = alone.robot->joints();
  for (std::size_t j = 0; j < joints.size(); ++j)
    out.names.push_back(fmt::format("u_{}", j + 1)), out.columns.push_back(track->value[j]);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    RandomStream stream(seed, index, static_cast<std::uint32_t>(j), kNoiseDraws);
    out.names.push_back(fmt::format("q_{}", j + 1)), out.columns.emplace_back();
    for (const std::vector<double>& q : run.q) out.columns.back().push_back(q[j] + noise[j] * stream.normal());
  }
  return out;
}

/// Columns as recording_of names them.
ChannelSpecs channels_of(const Scenario& scenario) {
  ChannelSpecs out;
  out.time = "t";
  const auto commands = scenario.channels.of.find(ChannelKind::command);
  for (std::size_t j = 0; j < scenario.robot->joints().size(); ++j) {
    const std::string& joint = scenario.robot->joints()[j].name;
    out.of[ChannelKind::position][joint] = {fmt::format("q_{}", j + 1), 1.0, 0.0, ""};
    if (commands == scenario.channels.of.end() || commands->second.count(joint) == 0) continue;
    ColumnSpec column{fmt::format("u_{}", j + 1), 1.0, 0.0, ""};
    column.unit = commands->second.at(joint).unit;
    out.of[ChannelKind::command][joint] = column;
  }
  return out;
}

/// A case of its own: what A recorded at one step, and B's plain plant, which knows neither A's friction nor its step.
Scenario write_case(const fs::path& folder, const Scenario& scenario, const std::vector<Recorded>& recorded,
                    std::size_t run, const std::vector<double>& noise, std::uint64_t seed) {
  Scenario out = scenario;
  out.file = folder / "scenario.yaml";
  out.robot_file = fs::absolute(resolve(scenario, scenario.robot_file)).lexically_normal().string();
  std::erase_if(out.effects,
                [](const EffectSpec& spec) { return spec.effect == "coulomb_friction" || only_reads(spec); });
  out.events.clear(), out.motion.reset(), out.noise.clear();
  out.channels = channels_of(scenario);
  for (std::size_t j = 0; j < noise.size(); ++j)
    out.noise[ChannelKind::position][scenario.robot->joints()[j].name] = noise[j];
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    const std::string name = fmt::format("recording_{}.csv", i + 1);
    make_parent_folder(folder / name);
    write_csv(folder / name,
              recording_of(recorded[i].alone, recorded[i].runs[run], noise, seed, static_cast<std::uint32_t>(i)));
    for (RecordingSpec& spec : out.recordings)
      if (spec.file == recorded[i].file) spec.file = name;
    for (EffectSpec& effect : out.effects) std::ranges::replace(effect.recordings, recorded[i].file, name);
  }
  save_scenario(out, out.file);
  return load_scenario(out.file);
}

SimulatorSide side_of(const Diagnosis& diagnosis, double step) {
  SimulatorSide out;
  out.step = step, out.verdict = to_string(diagnosis.verdict);
  for (const Estimate& e : diagnosis.after.estimates)
    out.numbers.push_back({e.name, e.unit, e.value, 0.5 * (e.upper95 - e.lower95)});
  for (const Finding& f : diagnosis.findings) out.effects.push_back({f.effect, f.place, f.probability});
  const Role role = judged_role(diagnosis.before);
  out.before = rms_in(diagnosis.before, role), out.after = rms_in(diagnosis.after, role);
  return out;
}

/// Diagnosed on engine B, and its own report written beside the case.
SimulatorSide diagnosed(Session& session, const std::string& engine, const Scenario& scenario, double step, double done,
                        ProgressLine& progress) {
  DiagnoseFlags flags;
  flags.identify.engine = engine;
  flags.identify.generations = 20;
  flags.no_engines = true;
  const fs::path folder = scenario.folder();
  const Diagnosis diagnosis = run_diagnosis(session, flags, scenario, folder, [&](const Progress& p) {
    progress.update(fmt::format("{} at {:g} ms: {}", engine, 1e3 * step, p.stage), done + 0.48 * p.done);
  });
  write_diagnosis_report(folder, scenario, diagnosis, session.context(), {});
  DiagnosisCheckpoint::remove(folder / "checkpoint.json");
  return side_of(diagnosis, step);
}

std::vector<SimulatorRest> rests_of(const SimulatorComparison& c, const std::vector<double>& noise) {
  std::vector<SimulatorRest> out;
  for (std::size_t j = 0; j < c.joints.size(); ++j) {
    SimulatorRest one{c.joints[j],
                      c.steps[j].unit,
                      noise[j],
                      entry_of(c.at_step.before, c.joints[j]),
                      entry_of(c.at_step.after, c.joints[j]),
                      entry_of(c.at_half.after, c.joints[j])};
    if (!std::isfinite(one.at_step) || !std::isfinite(one.at_half)) continue;
    one.origin = origin_of_rest(one.noise, one.at_step, one.at_half);
    out.push_back(one);
  }
  return out;
}

SimulatorComparison compared(Session& session, const SimulatorFlags& flags, const Scenario& scenario,
                             const fs::path& folder) {
  const auto [a, b] = two_engines(flags.engines);
  SimulatorComparison out;
  out.scenario = scenario.name, out.other = b, out.method = method_of(a, flags.integrator), out.step = flags.step;
  const NativePlant plant = native_plant(scenario, flags.own_friction);
  for (const Joint& joint : scenario.robot->joints()) out.joints.push_back(joint.name);
  out.losses = plant.losses;
  ProgressLine progress("preparing");
  const std::vector<Recorded> recorded = record(scenario, plant, out.method, flags.step, progress);
  std::vector<std::vector<StepDependence>> steps;
  for (const Recorded& one : recorded) steps.push_back(step_dependence(*scenario.robot, one.runs));
  out.steps = pooled(steps);
  std::vector<double> orders;
  for (const StepDependence& one : out.steps)
    if (std::isfinite(one.order)) orders.push_back(one.order);
  std::ranges::sort(orders);
  if (!orders.empty())
    out.order = orders[orders.size() / 2];
  else
    out.notes.push_back("No joint shows an order in the step between .5 and 4: first order was taken.");
  const std::vector<double> noise = noise_of(scenario, recorded);
  const Scenario whole = write_case(folder / "step", scenario, recorded, 0, noise, session.seed);
  const Scenario half = write_case(folder / "half_step", scenario, recorded, 1, noise, session.seed);
  check_diagnosable(whole);
  out.at_step = diagnosed(session, b, whole, flags.step, 0.04, progress);
  out.at_half = diagnosed(session, b, half, 0.5 * flags.step, 0.52, progress);
  out.numbers = tell_apart(out.at_step, out.at_half, plant.given, out.order);
  out.rests = rests_of(out, noise);
  return out;
}

std::string summary(const SimulatorComparison& c) {
  TextTable numbers({"number", ">built with", ">at h", ">at h/2", ">at step 0", "unit", "origin"});
  for (const SimulatorNumber& n : c.numbers)
    if (n.origin != Origin::as_built || std::ranges::count(n.name, '.') > 1)
      numbers.add({n.name, number(n.given), number(n.at_step), number(n.at_half), number(n.at_zero), n.unit,
                   origin_words(n.origin)});
  TextTable rests({"residual rms", ">noise", ">plain, h", ">found, h", ">found, h/2", "unit", "what remains is"});
  for (const SimulatorRest& r : c.rests)
    rests.add({r.joint, steady(r.noise), steady(r.before), steady(r.at_step), steady(r.at_half), r.unit,
               r.origin == Origin::as_built ? "noise" : origin_words(r.origin)});
  return wrapped(simulators_sentence(c), 110, 0) + "\n\n" + (numbers.empty() ? "" : numbers.str() + "\n") + rests.str();
}

}  // namespace

void add_simulator_options(CLI::App& command, SimulatorFlags& flags) {
  command.add_option(
      "--simulators", flags.engines,
      "A,B: recordings made by engine A's own stepping, damping and friction, diagnosed on engine B;\n"
      "what is found is told apart: the integrator's, which shrinks with A's step, and physics. Instead\n"
      "of the comparison; writes simulators.json, report.html and both diagnoses");
  command
      .add_option("--step", flags.step, "With --simulators: A's step h, s (default: 0.002); h/2 and h/4 are run, too")
      ->check(CLI::Range(1e-6, 1.0));
  command.add_option("--integrator", flags.integrator, "With --simulators: A's integrator (default: its own default)");
  command.add_option(
      "--own-friction", flags.own_friction,
      "With --simulators: A's dry friction, where the scenario states none, as a share of gain times the\n"
      "rms command (default: 0.05)");
}

void run_simulators(Session& session, const SimulatorFlags& flags) {
  const auto begun = std::chrono::steady_clock::now();
  two_engines(flags.engines);  // refuses at once
  const Scenario scenario = load_scenario(session.scenario_file);
  log_notes(scenario);
  const fs::path folder = session.output_folder(scenario);
  SimulatorComparison comparison = compared(session, flags, scenario, folder);
  comparison.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  const Context context = session.context();
  write_simulators_report(folder, comparison, context);
  if (session.json) return print(to_json(comparison, context));
  print(summary(comparison) +
        fmt::format("\n{}; written to {}: simulators.json, report.html, and both diagnoses in step/ and "
                    "half_step/\n",
                    duration(comparison.seconds), folder.string()));
}

}  // namespace lacuna
