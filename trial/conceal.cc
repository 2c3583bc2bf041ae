#include "trial/conceal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "ga/random.h"
#include "scenarios/error.h"
#include "scenarios/recording_choice.h"
#include "scenarios/text.h"
#include "trial/true_machine.h"

namespace lacuna {
namespace {

constexpr double kCorrelated = 5.0;                    // sampling periods over which coloured noise falls to 1/e
constexpr double kStepShare = 0.8, kWhiteShare = 0.6;  // of quantised noise' rms: steps and what lies beneath them
constexpr std::uint32_t kNoise = 42;                   // use of random draws: streams of its own

using Channels = TrueMachine::Channels;

/// Nothing simulates the pressures of a joint whose actuator has no chambers.
void leave_out_pressures_of_no_chamber(Scenario& scenario) {
  for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b}) {
    const auto channels = scenario.channels.of.find(kind);
    if (channels == scenario.channels.of.end()) continue;
    std::erase_if(channels->second, [&](const auto& channel) { return !has_chambers(scenario, channel.first); });
    if (!channels->second.empty()) continue;
    scenario.channels.of.erase(channels);
    scenario.noise.erase(kind);
  }
}

/// The scenario with each file once, simulated whole, and only what can be simulated measured.
Scenario free_runs_of(const Scenario& scenario) {
  Scenario out = scenario;
  out.recordings = recordings_of(scenario);
  out.prediction = FreeRun{}, out.pressure_driven = false;
  leave_out_pressures_of_no_chamber(out);
  return out;
}

/// One channel as its transducer gives it.
void add_noise(std::vector<double>& signal, const std::vector<double>& time, double rms, double period, NoiseKind kind,
               RandomStream stream) {
  const double step = kStepShare * rms * std::sqrt(12.0);
  double colour = stream.normal();
  for (std::size_t i = 0; i < signal.size(); ++i) {
    if (i > 0) {
      const double kept = std::exp(-(time[i] - time[i - 1]) / (kCorrelated * period));
      colour = kept * colour + std::sqrt(1.0 - kept * kept) * stream.normal();
    }
    switch (kind) {
      case NoiseKind::white: signal[i] += rms * stream.normal(); break;
      case NoiseKind::coloured: signal[i] += rms * colour; break;
      case NoiseKind::quantised:
        signal[i] = step * std::round((signal[i] + kWhiteShare * rms * stream.normal()) / step) + 0.0;  // no -0
        break;
    }
  }
}

/// A value of the column to the digit that is a thirtieth of its noise, as loggers write it.
double written(double value, double noise) {
  const double digit = std::pow(10.0, std::floor(std::log10(noise / 30.0)));
  // Divided by a whole number of digits, the result is the decimal number itself.
  const double inverse = std::round(1.0 / digit);
  return inverse >= 1.0 ? std::round(value * inverse) / inverse : std::round(value / digit) * digit;
}

/// Name of a recording in the new case: the scenario's own, unless that leads out of its folder.
std::string csv_name(const std::string& file) {
  std::filesystem::path path = std::filesystem::path(file).lexically_normal();
  if (path.is_absolute() || path.empty() || *path.begin() == "..") path = path.filename();
  return path.replace_extension(".csv").generic_string();
}

/// The recording's time and commands as they were, its measured columns as the true machine moved.
Recording recorded(const Scenario& scenario, const TrueMachine& machine, const Segment& segment, const Channels& moved,
                   const ConcealOptions& options) {
  const Experiment& experiment = machine.experiment();
  const RecordingSpec& spec = scenario.recordings[segment.recording];
  const Recording& data = *spec.data;
  std::map<std::string, std::vector<double>> measured;
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const ColumnSpec& column = scenario.channels.of.at(channel.kind).at(experiment.joint_names[channel.joint]);
    std::vector<double> values = moved[c];
    add_noise(values, segment.commands->time, channel.noise, experiment.sample_period, options.noise,
              RandomStream(options.seed, static_cast<std::uint32_t>(segment.recording), static_cast<std::uint32_t>(c),
                           kNoise));
    repeat_samples(machine.outside, channel, segment, values);
    for (double& value : values) {
      value = (value - column.offset) / column.scale;
      if (options.noise != NoiseKind::quantised) value = written(value, std::fabs(channel.noise / column.scale));
    }
    measured[column.column] = std::move(values);
  }
  std::vector<std::string> kept{scenario.channels.time};
  if (const auto commands = scenario.channels.of.find(ChannelKind::command); commands != scenario.channels.of.end())
    for (const auto& [unused, column] : commands->second) kept.push_back(column.column);
  const auto& time = data.columns[data.find(scenario.channels.time)];
  const auto first = std::lower_bound(time.begin(), time.end(), spec.from.value_or(-HUGE_VAL)) - time.begin();
  Recording out;
  out.file = csv_name(spec.file);
  for (std::size_t i = 0; i < data.names.size(); ++i) {
    const auto at = measured.find(data.names[i]);
    const bool given = std::find(kept.begin(), kept.end(), data.names[i]) != kept.end();
    if (!given && at == measured.end()) continue;
    out.names.push_back(data.names[i]);
    const auto begin = data.columns[i].begin() + first;
    out.columns.push_back(given ? std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(segment.count))
                                : std::move(at->second));
  }
  return out;
}

/// The scenario as it is handed over: new recordings under their roles, the noise stated.
Scenario handed_over(const Scenario& given, const Scenario& runs, const Experiment& experiment,
                     const std::vector<std::shared_ptr<const Recording>>& recordings) {
  Scenario out = given;
  leave_out_pressures_of_no_chamber(out);
  out.noise.clear();
  for (const Channel& channel : experiment.channels)
    out.noise[channel.kind][experiment.joint_names[channel.joint]] = channel.noise;
  for (RecordingSpec& spec : out.recordings) {
    for (std::size_t r = 0; r < runs.recordings.size(); ++r)
      if (csv_name(runs.recordings[r].file) == csv_name(spec.file)) spec.data = recordings[r];
    spec.file = csv_name(spec.file);
    spec.with.clear(), spec.log_times = false;  // the new file has one clock
  }
  for (EffectSpec& effect : out.effects)
    for (std::string& file : effect.recordings) file = csv_name(file);
  return out;
}

void refuse_shared_names(const Scenario& runs) {
  std::vector<std::string> names;
  for (const RecordingSpec& spec : runs.recordings) names.push_back(csv_name(spec.file));
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end())
    throw InputError(runs.file.string() + ": recordings", "two files that would both become " + quoted(*twice),
                     "names that differ before their extension");
}

/// Measured efforts say what a motion needed, not how it was commanded: nothing would drive the true machine.
void refuse_undriven(const Scenario& scenario) {
  const bool inverse = std::holds_alternative<InverseDynamics>(scenario.prediction);
  if ((inverse || scenario.pressure_driven) && !scenario.channels.of.contains(ChannelKind::command))
    throw InputError(scenario.file.string() + ": channels", "no command",
                     "command: {JOINT: COLUMN, ...}, which the true machine is simulated from (efforts of arms drawn "
                     "anew: scripts/effort_suite)");
}

void check_files(const Scenario& runs, const std::vector<HiddenEffect>& effects) {
  for (const HiddenEffect& effect : effects) {
    for (const std::string& file : effect.recordings) {
      std::vector<std::string> known;
      for (const RecordingSpec& spec : runs.recordings) known.push_back(spec.file);
      if (std::find(known.begin(), known.end(), file) == known.end())
        throw InputError("--recordings", quoted(file), "a recording of the scenario: " + one_of(known));
    }
  }
}

std::vector<ConcealedEffect> concealed_effects(const Scenario& runs, const TrueMachine& machine,
                                               const ConcealOptions& options) {
  std::vector<ConcealedEffect> out;
  for (const Hidden& effect : machine.hidden) {
    const std::size_t k = out.size();
    out.push_back({effect.asked(), effect.strength(), effect.parameters(), {}});
    if (k < machine.uneven().size() && machine.uneven()[k].share > 0.0) out.back().uneven = machine.uneven()[k];
    if (options.imperfections.drift == 0.0 || !effect.varies()) continue;
    for (std::size_t r = 0; r < runs.recordings.size(); ++r)
      out.back().drift.emplace_back(csv_name(runs.recordings[r].file),
                                    effect.strength_of(machine.effects_in(static_cast<int>(r), machine.laws())[k]));
  }
  if (machine.outside.empty()) return out;
  const Travel travel = machine.travel(machine.laws());
  std::vector<std::string> files;
  for (const RecordingSpec& spec : runs.recordings) files.push_back(csv_name(spec.file));
  std::size_t outside = 0;
  for (const HiddenEffect& asked : options.effects) {
    if (!asked.outside) continue;
    const OutsidePhysics& physics = machine.outside[outside++];
    out.push_back({asked, physics.strength, {}, law_record(physics, travel, machine.experiment(), files)});
  }
  return out;
}

/// One recording per entry of `runs`, noise included.
std::vector<std::shared_ptr<const Recording>> record_all(const Scenario& runs, const TrueMachine& machine,
                                                         const ConcealOptions& options) {
  const Experiment& experiment = machine.experiment();
  std::vector<int> all(experiment.segments.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const std::vector<Channels> moved = machine.motion(all, machine.laws(), kTruthTolerance);
  std::vector<std::shared_ptr<const Recording>> out(runs.recordings.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Segment& segment = experiment.segments[i];
    out[segment.recording] = std::make_shared<const Recording>(recorded(runs, machine, segment, moved[i], options));
  }
  return out;
}

std::vector<std::pair<std::string, double>> truth_of(const TrueMachine& machine) {
  std::vector<int> free;
  for (const Axis& axis : machine.space().axes()) free.push_back(axis.parameter);
  if (machine.space().dependent() >= 0) free.push_back(machine.space().dependent());
  std::vector<std::pair<std::string, double>> out;
  for (const int index : free) {
    out.emplace_back(machine.plain().parameters()[index].name, machine.values()[index]);
  }
  return out;
}

std::vector<std::pair<std::string, double>> noise_of(const Experiment& experiment) {
  std::vector<std::pair<std::string, double>> out;
  for (const Channel& channel : experiment.channels) {
    const std::string& joint = experiment.joint_names[channel.joint];
    const bool position = channel.kind == ChannelKind::position;
    out.emplace_back(position ? joint : joint + "." + to_string(channel.kind), channel.noise);
  }
  return out;
}

}  // namespace

const char* to_string(NoiseKind kind) {
  switch (kind) {
    case NoiseKind::white: return "white";
    case NoiseKind::coloured: return "coloured";
    default: return "quantised";
  }
}

NoiseKind noise_from_name(const std::string& name) {
  for (const NoiseKind kind : {NoiseKind::white, NoiseKind::coloured, NoiseKind::quantised})
    if (name == to_string(kind)) return kind;
  throw InputError("--noise", quoted(name), "white, coloured or quantised");
}

Concealment conceal(const Scenario& original, const ConcealOptions& options) {
  refuse_undriven(original);
  const Scenario scenario = shortened(original, options.imperfections);
  const Scenario runs = free_runs_of(scenario);
  refuse_shared_names(runs);
  check_files(runs, options.effects);
  TrueMachine machine(runs, options);
  machine.set_strengths();
  Concealment out;
  out.effects = concealed_effects(runs, machine, options);
  std::tie(out.raw_rms_over_noise, out.left_rms_over_noise) = machine.visibility(machine.laws(), kTruthTolerance);
  out.scenario = handed_over(scenario, runs, machine.experiment(), record_all(runs, machine, options));
  out.misplaced = machine.misplaced();
  out.truth = truth_of(machine);
  out.noise = noise_of(machine.experiment());
  return out;
}

}  // namespace lacuna
