// `lacuna simulate`: what the scenario's model predicts, as recordings of the same columns.
#include "physics/simulator.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/progress.h"
#include "cli/settings.h"
#include "cli/table.h"
#include "reports/json_text.h"
#include "reports/wording.h"
#include "scenarios/error.h"
#include "scenarios/recording_choice.h"
#include "scenarios/scenario_parser.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct SimulateOptions {
  std::string engine = "featherstone";
  std::string recording;
  std::vector<std::string> settings;
  double step = 0.0;  ///< s; 0: chosen
};

struct Simulated {
  Recording columns;  ///< time, commands and simulated channels; `file` as the scenario writes it
  std::size_t samples = 0;
  StepChoice step;
  fs::path written;
};

/// Accuracy asked of a channel that was never measured, as a share of the range that it moves over.
constexpr double kUnmeasuredShare = 1e-6;

using Channels = std::vector<std::vector<double>>;

Channels predict(const PlantModel& model, const Experiment& experiment, const SimulatorOptions& options,
                 const std::vector<double>& values) {
  Channels out;
  const std::vector<std::vector<double>> one{values};
  const std::vector<int> segments{0};
  make_simulator(model, experiment, options)->run(one, segments, [&](int, int, const Channels& predicted) {
    out = predicted;
  });
  return out;
}

bool finite(const Channels& channels) {
  return std::all_of(channels.begin(), channels.end(), [](const std::vector<double>& column) {
    return std::all_of(column.begin(), column.end(), [](double x) { return std::isfinite(x); });
  });
}

/// Gives channels without a known noise one, so that the step is chosen for them too.
void set_accuracy(const PlantModel& model, Experiment& experiment, SimulatorOptions options,
                  const std::vector<double>& values) {
  const auto known = [](const Channel& channel) { return channel.noise > 0.0; };
  if (std::all_of(experiment.channels.begin(), experiment.channels.end(), known)) return;
  Channels rough;
  for (const double step : {1e-2, 1e-3, 1e-4}) {
    options.max_step = step;
    rough = predict(model, experiment, options, values);
    if (finite(rough)) break;
  }
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    if (known(experiment.channels[c])) continue;
    const auto [low, high] = std::minmax_element(rough[c].begin(), rough[c].end());
    experiment.channels[c].noise = std::max(kUnmeasuredShare * (*high - *low), 1e-12);
  }
}

[[noreturn]] void refuse_diverged(const std::string& file, const Segment& segment, const Channels& predicted) {
  std::size_t sample = segment.count;
  for (const auto& column : predicted) {
    const auto bad = std::find_if(column.begin(), column.end(), [](double x) { return !std::isfinite(x); });
    sample = std::min(sample, static_cast<std::size_t>(bad - column.begin()));
  }
  throw WorkError(
      fmt::format("the simulation of {} diverges {:.6g} s after its start", printable(file), segment.time(sample)));
}

/// Columns in the recording's own order and names, values as the recording would hold them.
Recording as_recording(const Scenario& scenario, const Experiment& experiment, const Channels& predicted) {
  const RecordingSpec& spec = scenario.recordings.front();
  const Recording& data = *spec.data;
  const auto& time = data.columns[data.find(scenario.channels.time)];
  const auto first = std::lower_bound(time.begin(), time.end(), spec.from.value_or(-HUGE_VAL)) - time.begin();
  const auto rows = static_cast<std::ptrdiff_t>(experiment.segments.front().count);
  std::map<std::string, std::vector<double>> simulated;
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const ColumnSpec& column = scenario.channels.of.at(channel.kind).at(experiment.joint_names[channel.joint]);
    std::vector<double> values = predicted[c];
    for (double& value : values) value = (value - column.offset) / column.scale;
    simulated[column.column] = std::move(values);
  }
  std::vector<std::string> copied{scenario.channels.time};
  if (const auto commands = scenario.channels.of.find(ChannelKind::command); commands != scenario.channels.of.end())
    for (const auto& [unused, column] : commands->second) copied.push_back(column.column);
  Recording out;
  out.file = spec.file;
  for (std::size_t i = 0; i < data.names.size(); ++i) {
    const bool keep = std::find(copied.begin(), copied.end(), data.names[i]) != copied.end();
    const auto at = simulated.find(data.names[i]);
    if (!keep && at == simulated.end()) continue;
    out.names.push_back(data.names[i]);
    const auto begin = data.columns[i].begin() + first;
    out.columns.push_back(keep ? std::vector<double>(begin, begin + rows) : std::move(at->second));
  }
  return out;
}

Simulated simulate(const Scenario& scenario, const SetPlant& plant, const SimulateOptions& options,
                   const Session& session) {
  Experiment experiment = make_experiment(scenario);
  SimulatorOptions simulator{options.engine, session.threads, options.step, &stop_flag()};
  Simulated out;
  out.step = {options.step, std::nan("")};
  if (!(options.step > 0.0)) {
    set_accuracy(plant.model, experiment, simulator, plant.values);
    out.step = choose_step(plant.model, experiment, simulator, plant.values);
  }
  simulator.max_step = out.step.step;
  const Channels predicted = predict(plant.model, experiment, simulator, plant.values);
  if (!finite(predicted)) refuse_diverged(scenario.recordings.front().file, experiment.segments.front(), predicted);
  out.columns = as_recording(scenario, experiment, predicted);
  out.samples = out.columns.rows();
  return out;
}

std::string csv_text(const Recording& recording) {
  std::string out;
  for (std::size_t c = 0; c < recording.names.size(); ++c) {
    std::string name = recording.names[c];
    if (name.find_first_of(",\"") != std::string::npos) {
      for (std::size_t at = 0; (at = name.find('"', at)) != std::string::npos; at += 2) name.insert(at, 1, '"');
      name.insert(0, 1, '"').append(1, '"');
    }
    out.append(c > 0 ? "," : "").append(name);
  }
  out += '\n';
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    for (std::size_t c = 0; c < recording.columns.size(); ++c)
      out.append(c > 0 ? "," : "").append(format_number(recording.columns[c][row]));
    out += '\n';
  }
  return out;
}

/// Where a recording's simulation goes: below the output folder, under the recording's own relative name.
fs::path target_of(const Session& session, const Scenario& scenario, const RecordingSpec& spec) {
  const fs::path written = fs::path(spec.file).lexically_normal();
  const bool inner = written.is_relative() && *written.begin() != "..";
  fs::path target = fs::path(session.output) / (inner ? written : written.filename());
  target.replace_extension(".csv");
  refuse_overwriting(resolve(scenario, spec.file), target);
  return target;
}

Json to_json(const Simulated& simulated) {
  Json out = {{"file", simulated.columns.file},
              {"samples", simulated.samples},
              {"columns", simulated.columns.names},
              {"step", simulated.step.step},
              {"error_over_noise",
               std::isfinite(simulated.step.error_over_noise) ? Json(simulated.step.error_over_noise) : Json(nullptr)}};
  if (!simulated.written.empty()) {
    out["written"] = simulated.written.string();
    return out;
  }
  for (std::size_t c = 0; c < simulated.columns.names.size(); ++c)
    out["data"][simulated.columns.names[c]] = simulated.columns.columns[c];
  return out;
}

void report(const Session& session, const Scenario& scenario, const SimulateOptions& options,
            const std::vector<Simulated>& all) {
  if (session.json) {
    Json out = {{"format", "lacuna-simulation/1"},
                {"version", version()},
                {"scenario", scenario.name},
                {"engine", options.engine},
                {"recordings", Json::array()}};
    for (const Simulated& one : all) out["recordings"].push_back(to_json(one));
    print(json_text(out));
    return;
  }
  if (session.output.empty()) {
    print(csv_text(all.front().columns));
    return;
  }
  TextTable table({"recording", ">samples", ">step", "written"});
  for (const Simulated& one : all)
    table.add(
        {one.columns.file, std::to_string(one.samples), quantity(1e3 * one.step.step, "ms"), one.written.string()});
  print(table.str());
}

std::vector<Simulated> simulate_all(const Session& session, const SimulateOptions& options, const Scenario& scenario,
                                    const SetPlant& plant, const std::vector<RecordingSpec>& specs,
                                    std::vector<std::string>& notes) {
  std::vector<Simulated> all;
  ProgressLine progress("simulating");
  for (const RecordingSpec& spec : specs) {
    progress.update("simulating " + printable(spec.file, 60),
                    static_cast<double>(all.size()) / static_cast<double>(specs.size()));
    const fs::path target = session.output.empty() ? fs::path() : target_of(session, scenario, spec);
    const Scenario one = with_recording(scenario, spec);
    notes.insert(notes.end(), one.notes.begin(), one.notes.end());
    all.push_back(simulate(one, plant, options, session));
    if (target.empty()) continue;
    make_parent_folder(target);
    write_csv(target, all.back().columns);
    all.back().written = target;
    all.back().columns.columns.clear();  // written: no need to hold them all
  }
  return all;
}

void run(const Session& session, const SimulateOptions& options) {
  engine_named(options.engine);
  const Scenario scenario = load_scenario(session.scenario_file, {.load_recordings = false});
  const SetPlant plant = plant_with(scenario, options.settings);
  std::vector<RecordingSpec> specs = recordings_of(scenario);
  if (!options.recording.empty()) specs = {recording_named(scenario, options.recording)};
  if (specs.empty())
    throw InputError(scenario.file.string() + ": recordings", "none", "at least one, or one named with --recording");
  if (session.output.empty()) specs.resize(1);
  std::vector<std::string> notes;
  const std::vector<Simulated> all = simulate_all(session, options, scenario, plant, specs, notes);
  log_notes(notes);
  report(session, scenario, options, all);
}

}  // namespace

void add_simulate(CLI::App& app, Session& session) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App& command = add_scenario_command(
      app, session, "simulate",
      "What the model predicts for a recording's commands: CSV with the recording's own columns.\n"
      "Without -o the first recording to standard output, with -o every recording into DIR",
      "lacuna simulate my_arm/scenario.yaml --set joint_2.gain=210 --recording test_1.csv > simulated.csv",
      [&session, options] { run(session, *options); });
  command.add_option("--engine", options->engine, "Engine to simulate on (default: featherstone)");
  command.add_option("--recording", options->recording,
                     "Recording that gives commands and start: one of the scenario's, or any file with its columns; "
                     "joints whose position it lacks start at rest at 0");
  command.add_option("--set", options->settings, "NAME=VALUE: a parameter changed; may be repeated")
      ->allow_extra_args(false);
  command.add_option("--step", options->step, "Largest integration step, s (default: chosen by halving)")
      ->check(CLI::Range(1e-6, 1.0));
}

}  // namespace lacuna
