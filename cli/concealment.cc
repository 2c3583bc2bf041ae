#include "cli/concealment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "cli/recording_choice.h"
#include "cli/settings.h"
#include "ga/least_squares.h"
#include "ga/random.h"
#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr double kUnknownNoise = 1e-3;  // of a channel's range, where the scenario neither states nor shows its noise
constexpr double kCorrelated = 5.0;     // sampling periods over which coloured noise falls to 1/e
constexpr double kStepShare = 0.8, kWhiteShare = 0.6;  // of quantised noise' rms: steps and what lies beneath them
constexpr int kRefitIterations = 20;
constexpr double kTolerance = 1e-8, kRoughTolerance = 1e-6;  // of the truth's steps; rough while a strength is sought

/// Uses of random draws: each has streams of its own.
enum Purpose : std::uint32_t { kPerturb = 41, kNoise = 42, kWhen = 43 };

using Channels = std::vector<std::vector<double>>;

/// The scenario with each file once, simulated whole, and only what can be simulated measured.
Scenario free_runs_of(const Scenario& scenario) {
  Scenario out = scenario;
  out.recordings = recordings_of(scenario);
  out.prediction = FreeRun{};
  for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b}) {
    out.channels.of.erase(kind);
    out.noise.erase(kind);
  }
  return out;
}

void set_noise(Experiment& experiment) {
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    Channel& channel = experiment.channels[c];
    if (channel.noise > 0.0) continue;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Segment& segment : experiment.segments) {
      for (const double x : segment.measured[c])
        if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
    }
    channel.noise = high > low ? kUnknownNoise * (high - low) : kUnknownNoise;
  }
}

/// Every free parameter moved up or down by a share within [least, most]; a start value of 0 by that share of its bounds.
std::vector<double> perturbed(const PlantModel& model, const Scenario& scenario, const SearchSpace& space,
                              const ConcealOptions& options) {
  std::vector<double> values = model.values();
  std::vector<std::size_t> masses;
  std::vector<int> free;
  for (const Axis& axis : space.axes()) free.push_back(axis.parameter);
  if (space.dependent() >= 0) free.push_back(space.dependent());
  const Box box = space.box(model);
  double before = 0.0, after = 0.0;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const std::size_t i = static_cast<std::size_t>(free[k]);
    RandomStream stream(options.seed, static_cast<std::uint32_t>(i), 0, kPerturb);
    const double share =
        stream.uniform(options.perturb_least, options.perturb_most) * (stream.chance(0.5) ? 1.0 : -1.0);
    const double start = values[i];
    const bool searched = k < space.size(), inverse = searched && space.axes()[k].coordinate == Coordinate::inverse;
    const double width = searched && !inverse ? box.upper[k] - box.lower[k] : 0.0;
    values[i] = start != 0.0 ? start * (1.0 + share) : 0.5 * share * width;
    if (searched && !inverse)
      values[i] = std::clamp(values[i], box.lower[k] + 0.02 * width, box.upper[k] - 0.02 * width);
    if (model.parameters()[i].info != nullptr) continue;
    masses.push_back(i);
    before += start;
    after += values[i];
  }
  if (!scenario.total_mass || masses.empty()) return values;
  // A known total stays: the free masses are scaled together, and what the bounds refuse goes to the dependent one.
  double fixed = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (model.parameters()[i].info == nullptr) fixed += model.parameters()[i].value;
  fixed -= before;
  for (const std::size_t i : masses) values[i] *= (*scenario.total_mass - fixed) / after;
  return space.expand(space.contract(values));
}

/// An effect of the catalogue at its place with all its parameters.
class Hidden {
 public:
  Hidden(const HiddenEffect& asked, const PlantModel& plain, const Experiment& experiment,
         std::span<const double> values)
      : asked_(asked), info_(effect_table()[static_cast<std::size_t>(find_effect(asked.effect))]) {
    const auto joint = plain.robot().find_joint(asked.place);
    const std::string where = "--effect " + printable(asked.effect + ":" + asked.place, 80);
    if (info_.where == Where::joint && !joint) {
      std::vector<std::string> names;
      for (const Joint& known : plain.robot().joints()) names.push_back(known.name);
      throw InputError(where, "the place " + quoted(asked.place), one_of(names));
    }
    if (info_.where == Where::arm && asked.place != "arm")
      throw InputError(where, "the place " + quoted(asked.place), "arm");
    if (!asked.recordings.empty() && !info_.per_recording)
      throw InputError("--recordings", "with " + asked.effect,
                       "an effect that may act in some recordings only, as payload");
    parameters_ = effect_parameters(info_, plain.robot(), joint ? *joint : -1);
    for (const EffectParameter& p : parameters_) {
      const double size = typical_size(p.info->scale, plain, experiment, p.joint, values);
      const bool typical = !p.info->starts.empty() && !p.info->optional;
      values_.push_back(typical ? typical_origin(p.info->scale, experiment, p.joint) + p.info->starts.front() * size
                                : p.info->neutral);
    }
    put_given(where);
    if (strength() == leading_parameter(info_).neutral)
      throw InputError(where, "a strength that does nothing", "another value");
  }

  const HiddenEffect& asked() const { return asked_; }
  double strength() const {
    const auto at = std::find_if(parameters_.begin(), parameters_.end(),
                                 [&](const EffectParameter& p) { return p.info == &leading_parameter(info_); });
    return values_[static_cast<std::size_t>(at - parameters_.begin())];
  }
  /// The effect `factor` times as strong.
  EffectSpec spec(double factor) const {
    EffectSpec out{asked_.effect, asked_.place, {}, asked_.recordings, "--effect"};
    for (std::size_t k = 0; k < values_.size(); ++k) {
      const ParameterInfo& p = *parameters_[k].info;
      out.parameters[parameters_[k].key] = std::clamp(strengthened(info_, p, values_[k], factor), p.lower, p.upper);
    }
    return out;
  }
  void scale(double factor) {
    const EffectSpec scaled = spec(factor);
    for (std::size_t k = 0; k < values_.size(); ++k) values_[k] = scaled.parameters.at(parameters_[k].key);
  }
  std::vector<std::pair<std::string, double>> parameters() const {
    std::vector<std::pair<std::string, double>> out;
    for (std::size_t k = 0; k < values_.size(); ++k) out.emplace_back(parameters_[k].key, values_[k]);
    return out;
  }

 private:
  void put_given(const std::string& where) {
    for (const auto& [name, value] : asked_.given) {
      std::size_t at = name.empty() ? 0 : parameters_.size();
      std::vector<std::string> known;
      for (std::size_t k = 0; k < parameters_.size(); ++k) {
        known.push_back(parameters_[k].key);
        if (name == known.back()) at = k;
      }
      if (at == parameters_.size()) throw InputError(where, "the parameter " + quoted(name), one_of(known));
      const ParameterInfo& p = *parameters_[at].info;
      if (!(value >= p.lower && value <= p.upper))
        throw InputError(
            where, format_number(value),
            fmt::format("{} from {} to {} {}", known[at], format_number(p.lower), format_number(p.upper), p.unit));
      // A strength alone keeps the typical proportions of those like it: break-away stays above sliding friction.
      const double factor = values_[at] != 0.0 ? value / values_[at] : 0.0;
      for (std::size_t k = 0; name.empty() && k < values_.size(); ++k)
        if (k != at && factor > 0.0 && parameters_[k].info->scale == p.scale && p.scale != Scale::ratio &&
            !parameters_[k].info->optional)
          values_[k] *= factor;
      values_[at] = value;
    }
  }

  HiddenEffect asked_;
  const EffectInfo& info_;
  std::vector<EffectParameter> parameters_;
  std::vector<double> values_;
};

/// The true machine: its simulations, and what a plain refit leaves of them.
class Machine {
 public:
  Machine(const Scenario& scenario, const ConcealOptions& options)
      : scenario_(scenario),
        options_(options),
        plain_(scenario),
        experiment_(make_experiment(scenario)),
        space_(plain_, scenario),
        values_(perturbed(plain_, scenario, space_, options)),
        train_(experiment_.with_role(Role::train)) {
    if (train_.empty())
      throw InputError(scenario.file.string() + ": recordings", "none with role train", "at least one");
    set_noise(experiment_);
    for (std::size_t k = 0; k < options.effects.size(); ++k) add(options.effects[k], k);
  }

  std::vector<Hidden> hidden;
  std::vector<OutsidePhysics> outside;
  const Experiment& experiment() const { return experiment_; }
  const SearchSpace& space() const { return space_; }
  const PlantModel& plain() const { return plain_; }
  const std::vector<double>& values() const { return values_; }

  /// [segment][channel][sample], noise-free.
  std::vector<Channels> motion(std::span<const int> segments, const std::vector<EffectSpec>& effects,
                               const std::vector<OutsidePhysics>& others, double tolerance) const {
    const PlantModel model = plain_.with_effects(effects);
    std::vector<double> values = model.values();
    std::copy(values_.begin(), values_.end(), values.begin());
    TruthOptions truth{.engine = options_.engine, .tolerance = tolerance, .outside = others, .stop = options_.stop};
    std::vector<Channels> out(segments.size());
    parallel_for(
        options_.threads, static_cast<int>(segments.size()),
        [&](int, int piece) {
          const std::size_t i = static_cast<std::size_t>(piece);
          const Segment& segment = experiment_.segments[static_cast<std::size_t>(segments[i])];
          out[i] = simulate_truth(model, segment, experiment_.channels, model.values_in(segment.file, values), truth);
        },
        options_.stop);
    return out;
  }

  /// Raw and left rms over noise of the train recordings: against the plain plant at the true values, and refitted.
  std::pair<double, double> visibility(const std::vector<EffectSpec>& effects,
                                       const std::vector<OutsidePhysics>& others, double tolerance) const {
    const std::vector<Channels> moved = motion(train_, effects, others, tolerance);
    Experiment seen = experiment_;
    for (std::size_t i = 0; i < train_.size(); ++i) {
      Segment& segment = seen.segments[static_cast<std::size_t>(train_[i])];
      segment.measured = moved[i];
      for (std::size_t c = 0; c < seen.channels.size(); ++c) {
        const std::size_t j = static_cast<std::size_t>(seen.channels[c].joint);
        if (seen.channels[c].kind == ChannelKind::position) segment.q0[j] = moved[i][c].front();
        if (seen.channels[c].kind == ChannelKind::position) segment.v0[j] = 0.0;
      }
    }
    SimulatorOptions simulator{"featherstone", options_.threads, 0.005, options_.stop};
    simulator.max_step = choose_step(plain_, seen, simulator, values_).step;
    std::vector<double> weights;
    for (const Channel& channel : seen.channels) weights.push_back(channel.noise);
    Problem problem(plain_, seen, space_, simulator, weights);
    const std::vector<double> start = space_.contract(values_);
    const Eigen::VectorXd raw = problem.residual(start, train_);
    const auto rms = [](double squares, Eigen::Index n) { return std::sqrt(squares / static_cast<double>(n)); };
    double left = raw.squaredNorm();
    if (space_.size() > 0) {
      LeastSquaresOptions finish;
      finish.iterations = kRefitIterations;
      finish.polish = false;
      finish.control.stop = options_.stop;
      left = std::min(left, solve_least_squares(problem, start, train_, finish).sum_of_squares);
    }
    return {rms(raw.squaredNorm(), raw.size()), rms(left, raw.size())};
  }

 private:
  void add(const HiddenEffect& asked, std::size_t index) {
    if (!asked.outside) {
      hidden.emplace_back(asked, plain_, experiment_, values_);
      return;
    }
    const std::string where = "--effect " + printable(asked.effect + ":" + asked.place, 80);
    const auto joint = scenario_.robot->find_joint(asked.place);
    if (!joint) throw InputError(where, "the place " + quoted(asked.place), "a joint");
    if (!asked.recordings.empty())
      throw InputError("--recordings", "with " + asked.effect,
                       "an effect that may act in some recordings only, as payload");
    const bool drops = *asked.outside == OutsidePhysics::Kind::command_dropout;
    const double effort = typical_size(Scale::effort, plain_, experiment_, *joint, values_);
    OutsidePhysics physics{*asked.outside, *joint, drops ? 0.3 : 0.2 * effort, {}};
    for (const auto& [name, value] : asked.given) {
      if (!name.empty() && name != "strength") throw InputError(where, "the parameter " + quoted(name), "strength");
      physics.strength = value;
    }
    if (!(physics.strength > 0.0) || !std::isfinite(physics.strength))
      throw InputError(where, format_number(physics.strength), "a strength above 0");
    physics.times = drawn_times(index);
    outside.push_back(std::move(physics));
  }

  /// Three instants a recording, one in each third.
  std::vector<std::vector<double>> drawn_times(std::size_t index) const {
    std::vector<std::vector<double>> out(scenario_.recordings.size());
    for (const Segment& segment : experiment_.segments) {
      RandomStream stream(options_.seed, static_cast<std::uint32_t>(segment.recording),
                          static_cast<std::uint32_t>(index), kWhen);
      const double span = segment.time(segment.count - 1);
      for (int third = 0; third < 3; ++third)
        out[static_cast<std::size_t>(segment.recording)].push_back(span * (third + stream.uniform(0.15, 0.85)) / 3.0);
    }
    return out;
  }

  const Scenario& scenario_;
  const ConcealOptions& options_;
  PlantModel plain_;
  Experiment experiment_;
  SearchSpace space_;
  std::vector<double> values_;
  std::vector<int> train_;
};

/// Finds the factor at which `left(factor)` is the visibility asked for: it grows with the factor, nearly in proportion.
template <class Left>
double factor_for(double visibility, const std::string& name, const Left& left) {
  constexpr int kTries = 9;
  constexpr double kCloseEnough = 0.05, kMostAtOnce = 8.0;
  double factor = 1.0, last_log = 0.0, last_seen = 0.0, slope = 1.0, seen = 0.0;
  for (int k = 0; k < kTries; ++k) {
    seen = left(factor);
    if (std::fabs(seen / visibility - 1.0) < kCloseEnough) return factor;
    if (!(seen > 0.0) || !std::isfinite(seen)) break;
    const double at = std::log(factor);
    if (k > 0 && std::fabs(at - last_log) > 1e-9)
      slope = std::clamp((std::log(seen) - std::log(last_seen)) / (at - last_log), 0.3, 3.0);
    last_log = at;
    last_seen = seen;
    factor *= std::clamp(std::pow(visibility / seen, 1.0 / slope), 1.0 / kMostAtOnce, kMostAtOnce);
  }
  throw WorkError(
      fmt::format("{} cannot be made as visible as {}: {:.3g} is what was reached", name, visibility, seen));
}

void set_strengths(Machine& machine, const ConcealOptions& options) {
  if (!options.visibility) return;
  for (Hidden& effect : machine.hidden) {
    const std::string name = effect.asked().effect + " at " + effect.asked().place;
    effect.scale(factor_for(*options.visibility, name, [&](double factor) {
      return machine.visibility({effect.spec(factor)}, {}, kRoughTolerance).second;
    }));
  }
  for (OutsidePhysics& physics : machine.outside) {
    physics.strength *= factor_for(*options.visibility, to_string(physics.kind), [&](double factor) {
      OutsidePhysics scaled = physics;
      scaled.strength *= factor;
      return machine.visibility({}, {scaled}, kRoughTolerance).second;
    });
  }
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
Recording recorded(const Scenario& scenario, const Experiment& experiment, const Segment& segment,
                   const Channels& moved, const ConcealOptions& options) {
  const RecordingSpec& spec = scenario.recordings[static_cast<std::size_t>(segment.recording)];
  const Recording& data = *spec.data;
  std::map<std::string, std::vector<double>> measured;
  for (std::size_t c = 0; c < experiment.channels.size(); ++c) {
    const Channel& channel = experiment.channels[c];
    const ColumnSpec& column =
        scenario.channels.of.at(channel.kind).at(experiment.joint_names[static_cast<std::size_t>(channel.joint)]);
    std::vector<double> values = moved[c];
    add_noise(values, segment.commands->time, channel.noise, experiment.sample_period, options.noise,
              RandomStream(options.seed, static_cast<std::uint32_t>(segment.recording), static_cast<std::uint32_t>(c),
                           kNoise));
    for (double& value : values) {
      value = (value - column.offset) / column.scale;
      if (options.noise != NoiseKind::quantised) value = written(value, std::fabs(channel.noise / column.scale));
    }
    measured[column.column] = std::move(values);
  }
  std::vector<std::string> kept{scenario.channels.time};
  if (const auto commands = scenario.channels.of.find(ChannelKind::command); commands != scenario.channels.of.end())
    for (const auto& [unused, column] : commands->second) kept.push_back(column.column);
  const auto& time = data.columns[static_cast<std::size_t>(data.find(scenario.channels.time))];
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
  for (const ChannelKind kind : {ChannelKind::pressure_a, ChannelKind::pressure_b}) out.channels.of.erase(kind);
  out.noise.clear();
  for (const Channel& channel : experiment.channels)
    out.noise[channel.kind][experiment.joint_names[static_cast<std::size_t>(channel.joint)]] = channel.noise;
  for (RecordingSpec& spec : out.recordings) {
    for (std::size_t r = 0; r < runs.recordings.size(); ++r)
      if (csv_name(runs.recordings[r].file) == csv_name(spec.file)) spec.data = recordings[r];
    spec.file = csv_name(spec.file);
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

std::vector<ConcealedEffect> concealed_effects(const Machine& machine, const ConcealOptions& options) {
  std::vector<ConcealedEffect> out;
  for (const Hidden& effect : machine.hidden) out.push_back({effect.asked(), effect.strength(), effect.parameters()});
  std::size_t outside = 0;
  for (const HiddenEffect& asked : options.effects)
    if (asked.outside) out.push_back({asked, machine.outside[outside++].strength, {}});
  return out;
}

/// One recording per entry of `runs`, noise included.
std::vector<std::shared_ptr<const Recording>> record_all(const Scenario& runs, const Machine& machine,
                                                         const std::vector<EffectSpec>& effects,
                                                         const ConcealOptions& options) {
  const Experiment& experiment = machine.experiment();
  std::vector<int> all(experiment.segments.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const std::vector<Channels> moved = machine.motion(all, effects, machine.outside, kTolerance);
  std::vector<std::shared_ptr<const Recording>> out(runs.recordings.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Segment& segment = experiment.segments[i];
    out[static_cast<std::size_t>(segment.recording)] =
        std::make_shared<const Recording>(recorded(runs, experiment, segment, moved[i], options));
  }
  return out;
}

std::vector<std::pair<std::string, double>> truth_of(const Machine& machine) {
  std::vector<int> free;
  for (const Axis& axis : machine.space().axes()) free.push_back(axis.parameter);
  if (machine.space().dependent() >= 0) free.push_back(machine.space().dependent());
  std::vector<std::pair<std::string, double>> out;
  for (const int index : free) {
    const std::size_t i = static_cast<std::size_t>(index);
    out.emplace_back(machine.plain().parameters()[i].name, machine.values()[i]);
  }
  return out;
}

std::vector<std::pair<std::string, double>> noise_of(const Experiment& experiment) {
  std::vector<std::pair<std::string, double>> out;
  for (const Channel& channel : experiment.channels) {
    const std::string& joint = experiment.joint_names[static_cast<std::size_t>(channel.joint)];
    const bool position = channel.kind == ChannelKind::position;
    out.emplace_back(position ? joint : joint + "." + to_string(channel.kind), channel.noise);
  }
  return out;
}

}  // namespace

HiddenEffect parse_hidden_effect(const std::string& text) {
  const std::string where = "--effect " + printable(text, 80),
                    form = "NAME:WHERE, NAME:WHERE:VALUE or NAME:WHERE:p=VALUE,...";
  const std::size_t first = text.find(':');
  if (first == std::string::npos || first == 0) throw InputError(where, quoted(text), form);
  const std::size_t second = text.find(':', first + 1);
  HiddenEffect out;
  out.effect = text.substr(0, first);
  out.place = text.substr(first + 1, second == std::string::npos ? std::string::npos : second - first - 1);
  out.outside = outside_physics_named(out.effect);
  if (!out.outside && find_effect(out.effect) < 0) {
    std::vector<std::string> names = outside_physics_names();
    for (const EffectInfo& info : effect_table()) names.emplace_back(info.name);
    throw InputError(where, "the effect " + quoted(out.effect), one_of(near_names(out.effect, names)));
  }
  if (second == std::string::npos) return out;
  for (std::size_t begin = second + 1; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.find('=');
    const std::string name = equals == std::string::npos ? "" : part.substr(0, equals);
    const auto value = parse_number(equals == std::string::npos ? part : part.substr(equals + 1));
    if (!value || !std::isfinite(*value) || (name.empty() && (equals == 0 || !out.given.empty())))
      throw InputError(where, quoted(part), form);
    out.given.emplace_back(name, *value);
    begin = end + 1;
  }
  return out;
}

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

Concealment conceal(const Scenario& scenario, const ConcealOptions& options) {
  const Scenario runs = free_runs_of(scenario);
  refuse_shared_names(runs);
  check_files(runs, options.effects);
  Machine machine(runs, options);
  set_strengths(machine, options);
  std::vector<EffectSpec> effects;
  for (const Hidden& effect : machine.hidden) effects.push_back(effect.spec(1.0));
  Concealment out;
  out.effects = concealed_effects(machine, options);
  std::tie(out.raw_rms_over_noise, out.left_rms_over_noise) = machine.visibility(effects, machine.outside, kTolerance);
  out.scenario = handed_over(scenario, runs, machine.experiment(), record_all(runs, machine, effects, options));
  out.truth = truth_of(machine);
  out.noise = noise_of(machine.experiment());
  return out;
}

}  // namespace lacuna
