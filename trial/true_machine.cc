#include "trial/true_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/candidates.h"
#include "ga/least_squares.h"
#include "ga/random.h"
#include "physics/effects/table.h"
#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

constexpr double kUnknownNoise = 1e-3;  // of a channel's range, where the scenario neither states nor shows its noise
constexpr int kRefitIterations = 20;
constexpr double kBeyondTravel = 1.5;      // of half the travel: where a contact that does nothing is put
constexpr double kWellBeyond = 3.0;        // the least that makes an effect what its name says
constexpr double kBackgroundShare = 1e-3;  // of typical efforts: what a background's response is measured with
constexpr double kUnmoved = 1e-9;          // of the noise: a joint whose drive lets nothing move it
constexpr double kRoughTolerance = 1e-6;   // of the truth's steps while a strength is sought

/// Uses of random draws: each has streams of its own, other than the recordings' noise.
enum MachineDraws : std::uint32_t { kPerturb = 41, kWhen = 43, kForm = 45, kUneven = 47, kDrift = 48 };

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

/// Every free parameter moved up or down by a share within [least, most]; a start value of 0 by that share of its
/// bounds.
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
    const std::size_t i = free[k];
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

/// Finds the factor at which `left(factor)` is the visibility asked for: it grows with the factor, mostly in
/// proportion; where it does not (a stop that is just met), between the nearest factors of too little and too much.
/// What grows in steps (whole samples) of so much of the factor, not 0, comes as near as a step does.
template <class Left>
double factor_for(double visibility, const std::string& name, double step, const Left& left) {
  constexpr int kTries = 16;
  constexpr double kCloseEnough = 0.05, kMostAtOnce = 8.0;
  double factor = 1.0, last_log = 0.0, last_seen = 0.0, slope = 1.0, seen = 0.0, too_little = 0.0, too_much = HUGE_VAL;
  double nearest = 1.0, miss = HUGE_VAL;
  for (int k = 0; k < kTries; ++k) {
    seen = left(factor);
    if (std::fabs(seen / visibility - 1.0) < kCloseEnough) return factor;
    if (!std::isfinite(seen) || (!(seen > 0.0) && !std::isfinite(too_much))) break;
    if (std::fabs(std::log(seen / visibility)) < miss) miss = std::fabs(std::log(seen / visibility)), nearest = factor;
    (seen < visibility ? too_little : too_much) = factor;
    if (step > 0.0 && too_much - too_little <= step) break;
    const double at = std::log(factor);
    if (k > 0 && seen > 0.0 && last_seen > 0.0 && std::fabs(at - last_log) > 1e-9)
      slope = std::clamp((std::log(seen) - std::log(last_seen)) / (at - last_log), 0.3, 3.0);
    last_log = at;
    last_seen = seen;
    if (seen > 0.0) factor *= std::clamp(std::pow(visibility / seen, 1.0 / slope), 1.0 / kMostAtOnce, kMostAtOnce);
    const bool beyond = !(seen > 0.0) || factor <= too_little || factor >= too_much;
    if (beyond) factor = std::sqrt(too_little * too_much);
  }
  if (step > 0.0 && std::isfinite(too_much)) return nearest;
  throw WorkError(
      fmt::format("{} cannot be made as visible as {}: {:.3g} is what was reached", name, visibility, seen));
}

}  // namespace

Hidden::Hidden(const HiddenEffect& asked, const PlantModel& plain, const Experiment& experiment,
               std::span<const double> values)
    : asked_(asked), info_(effect_table()[find_effect(asked.effect)]) {
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
  parameters_ = effect_parameters(info_, plain.robot(), info_.where == Where::joint ? *joint : -1);
  for (const EffectParameter& p : parameters_) {
    const double size = typical_size(p.info->scale, plain, experiment, p.joint, values);
    const bool typical = !p.info->starts.empty() && !p.info->optional;
    const double start = typical ? std::max(p.info->starts.front(), kWellBeyond * p.info->least) : 0.0;
    const double origin = typical_origin(p.info->scale, experiment, p.joint);
    values_.push_back(typical ? origin + start * size : p.info->neutral);
    if (p.info->scale == Scale::reach) reach_ = {origin - kBeyondTravel * size, origin + kBeyondTravel * size};
  }
  put_given(where);
  if (strength() == leading_parameter(info_).neutral)
    throw InputError(where, "a strength that does nothing", "another value");
}

double Hidden::strength() const {
  const auto at = std::find_if(parameters_.begin(), parameters_.end(),
                               [&](const EffectParameter& p) { return p.info == &leading_parameter(info_); });
  return values_[at - parameters_.begin()];
}

double Hidden::strength_of(const EffectSpec& spec) const {
  const auto at = std::ranges::find(parameters_, &leading_parameter(info_), &EffectParameter::info);
  return spec.parameters.at(at->key);
}

EffectSpec Hidden::spec(double factor) const {
  EffectSpec out{asked_.effect, asked_.place, {}, asked_.recordings, "--effect"};
  for (std::size_t k = 0; k < values_.size(); ++k) {
    const ParameterInfo& p = *parameters_[k].info;
    const double value = reach_ ? brought_nearer(p, values_[k], factor) : strengthened(info_, p, values_[k], factor);
    out.parameters[parameters_[k].key] = std::clamp(value, p.lower, p.upper);
  }
  return out;
}

double Hidden::brought_nearer(const ParameterInfo& p, double value, double factor) const {
  if (p.scale != Scale::reach) return value;
  const double end = strength() > 0.0 ? reach_->second : reach_->first;
  return end + factor * (value - end);
}

void Hidden::scale(double factor) {
  const EffectSpec scaled = spec(factor);
  for (std::size_t k = 0; k < values_.size(); ++k) values_[k] = scaled.parameters.at(parameters_[k].key);
}

std::vector<std::pair<std::string, double>> Hidden::parameters() const {
  std::vector<std::pair<std::string, double>> out;
  for (std::size_t k = 0; k < values_.size(); ++k) out.emplace_back(parameters_[k].key, values_[k]);
  return out;
}

void Hidden::put_given(const std::string& where) {
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
    if (p.scale == Scale::reach) reach_.reset();
  }
}

TrueMachine::TrueMachine(const Scenario& scenario, const ConcealOptions& options)
    : scenario_(scenario),
      options_(options),
      plain_(scenario),
      experiment_(make_experiment(scenario)),
      space_(plain_, scenario),
      values_(perturbed(plain_, scenario, space_, options)),
      train_(experiment_.with_role(Role::train)) {
  if (train_.empty()) throw InputError(scenario.file.string() + ": recordings", "none with role train", "at least one");
  set_noise(experiment_);
  for (std::size_t k = 0; k < options.effects.size(); ++k) add(options.effects[k], k);
  if (options.imperfections.uneven > 0.0) add_uneven();
  if (options.imperfections.drift > 0.0 && std::ranges::none_of(hidden, &Hidden::varies))
    throw InputError("--drift", "no hidden effect that could drift",
                     "an effect at a joint, other than a contact or a delay of the command");
  if (options.imperfections.background > 0.0) add_background();
  if (options.imperfections.misplaced > 0.0)
    misplaced_ = misplaced_centres(options.imperfections.misplaced, plain_, options.effects, options.seed);
}

bool Hidden::varies() const {
  const bool contact = std::any_of(parameters_.begin(), parameters_.end(),
                                   [](const EffectParameter& p) { return p.info->scale == Scale::reach; });
  return info_.where == Where::joint && info_.stage != Stage::command && !contact;
}

std::vector<int> Hidden::along_the_way() const {
  std::vector<int> out;
  if (!varies() || !acts_by_a_law(find_effect(info_.name))) return out;
  for (std::size_t k = 0; k < values_.size(); ++k) {
    const double value = values_[k], twice = strengthened(info_, *parameters_[k].info, value, 2.0);
    // A limit is stronger the lower it is.
    if (value != 0.0 && (twice == 2.0 * value || twice == 0.5 * value)) out.push_back(static_cast<int>(k));
  }
  return out;
}

std::vector<TrueMachine::Channels> TrueMachine::motion(std::span<const int> segments, const TrueLaws& laws,
                                                       double tolerance) const {
  return simulated(segments, experiment_.channels, laws, tolerance);
}

std::vector<EffectSpec> TrueMachine::effects_in(int recording, const TrueLaws& laws) const {
  std::vector<EffectSpec> out = laws.effects;
  const double share = options_.imperfections.drift;
  if (!laws.imperfect || share == 0.0) return out;
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    RandomStream stream(options_.seed, static_cast<std::uint32_t>(recording), static_cast<std::uint32_t>(k), kDrift);
    if (hidden[k].varies()) out[k] = hidden[k].spec(1.0 + share * stream.uniform(-1.0, 1.0));
  }
  return out;
}

/// Of a plant whose effects begin with its own, then the hidden ones.
std::vector<UnevenParameter> TrueMachine::uneven_in(const PlantModel& model) const {
  std::vector<UnevenParameter> out;
  for (std::size_t k = 0; k < uneven_.size(); ++k) {
    const Component& component = model.effects()[plain_.effects().size() + k];
    if (uneven_[k].share == 0.0) continue;
    for (const int p : hidden[k].along_the_way())
      out.push_back({component.first + p, component.joint, uneven_[k].over_command, uneven_[k].share, uneven_[k].centre,
                     uneven_[k].width});
  }
  return out;
}

std::vector<TrueMachine::Channels> TrueMachine::simulated(std::span<const int> segments,
                                                          const std::vector<Channel>& channels, const TrueLaws& laws,
                                                          double tolerance) const {
  std::vector<Channels> out(segments.size());
  parallel_for(
      options_.threads, static_cast<int>(segments.size()),
      [&](int, int piece) {
        Segment segment = experiment_.segments[segments[piece]];
        const PlantModel model = plain_.with_effects(effects_in(segment.recording, laws));
        std::vector<double> values = model.values();
        std::copy(values_.begin(), values_.end(), values.begin());
        TruthOptions truth{
            .engine = options_.engine, .tolerance = tolerance, .outside = laws.outside, .stop = options_.stop};
        if (laws.imperfect) truth.uneven = uneven_in(model);
        if (!laws.background.none()) laws.background.act(segment, truth.outside);
        out[piece] = simulate_truth(model, segment, channels, model.values_in(segment.file, values), truth);
      },
      options_.stop);
  return out;
}

Travel TrueMachine::travel(const TrueLaws& laws) const {
  const std::size_t n = plain_.dof();
  std::vector<Channel> channels;
  for (std::size_t k = 0; k < 2 * n; ++k) {
    channels.emplace_back();
    channels.back().kind = k < n ? ChannelKind::position : ChannelKind::velocity;
    channels.back().joint = static_cast<int>(k % n);
  }
  const auto moved = simulated(train_, channels, laws, kRoughTolerance);
  const auto range = [](const std::vector<double>& x) {
    const auto [low, high] = std::minmax_element(x.begin(), x.end());
    return Travel::Range{*low, *high};
  };
  Travel out;
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<double> position, speed, command;
    for (std::size_t i = 0; i < train_.size(); ++i) {
      const Segment& segment = experiment_.segments[train_[i]];
      const auto told = segment.commands->value[j].begin() + static_cast<std::ptrdiff_t>(segment.first);
      position.insert(position.end(), moved[i][j].begin(), moved[i][j].end());
      speed.insert(speed.end(), moved[i][n + j].begin(), moved[i][n + j].end());
      command.insert(command.end(), told, told + static_cast<std::ptrdiff_t>(segment.count));
    }
    out.position.push_back(range(position));
    out.command.push_back(range(command));
    out.speed_rms.push_back(root_mean_square(speed));
  }
  return out;
}

std::pair<double, double> TrueMachine::visibility(const TrueLaws& laws, double tolerance,
                                                  const std::vector<EffectSpec>& besides) const {
  std::vector<Channels> moved = motion(train_, laws, tolerance);
  Experiment seen = experiment_;
  for (std::size_t i = 0; i < train_.size(); ++i) {
    Segment& segment = seen.segments[train_[i]];
    for (std::size_t c = 0; c < seen.channels.size(); ++c)
      repeat_samples(laws.outside, seen.channels[c], segment, moved[i][c]);
    segment.measured = moved[i];
    for (std::size_t c = 0; c < seen.channels.size(); ++c) {
      const std::size_t j = seen.channels[c].joint;
      if (seen.channels[c].kind == ChannelKind::position) segment.q0[j] = moved[i][c].front();
      if (seen.channels[c].kind == ChannelKind::position) segment.v0[j] = 0.0;
    }
  }
  SimulatorOptions simulator{"featherstone", options_.threads, 0.005, options_.stop};
  simulator.max_step = choose_step(plain_, seen, simulator, values_).step;
  std::vector<double> weights;
  for (const Channel& channel : seen.channels) weights.push_back(channel.noise);
  const PlantModel model = plain_.with_effects(besides);
  SearchSpace space = space_;
  std::vector<double> start = space_.contract(values_);
  for (std::size_t k = 0; k < besides.size(); ++k) {
    const Component& component = model.effects()[plain_.effects().size() + k];
    for (const Axis& axis : effect_axes(model, seen, component, besides[k])) {
      space.add(model, axis);
      start.push_back(axis.start);
    }
  }
  Problem problem(model, seen, space, simulator, weights);
  const Eigen::VectorXd raw = problem.residual(start, train_);
  const auto rms = [](double squares, Eigen::Index n) { return std::sqrt(squares / static_cast<double>(n)); };
  double left = raw.squaredNorm();
  if (space.size() > 0) {
    LeastSquaresOptions finish;
    finish.iterations = kRefitIterations;
    finish.polish = false;
    finish.control.stop = options_.stop;
    left = std::min(left, solve_least_squares(problem, start, train_, finish).sum_of_squares);
  }
  return {rms(raw.squaredNorm(), raw.size()), rms(left, raw.size())};
}

void TrueMachine::set_strengths() {
  if (!options_.visibility) return;
  for (Hidden& effect : hidden) {
    const std::string name = effect.asked().effect + " at " + effect.asked().place;
    // A spring is hidden only if it shows, and not merely the inertia behind it: nobody could name it by that.
    std::vector<EffectSpec> besides;
    if (effect.contains() != nullptr) besides.push_back({effect.contains(), effect.asked().place, {}, {}, "--effect"});
    effect.scale(factor_for(*options_.visibility, name, 0.0, [&](double factor) {
      return visibility({.effects = {effect.spec(factor)}}, kRoughTolerance, besides).second;
    }));
  }
  for (OutsidePhysics& physics : outside) {
    const double start = physics.strength;
    const double step =
        physics.kind == OutsidePhysics::Kind::repeated_samples ? experiment_.sample_period / start : 0.0;
    const double factor = factor_for(*options_.visibility, to_string(physics.kind), step, [&](double tried) {
      OutsidePhysics scaled = physics;
      set_strength(scaled, tried * start);
      return visibility({.outside = {scaled}}, kRoughTolerance).second;
    });
    set_strength(physics, factor * start);
  }
}

/// rms over noise of what it changes in the train recordings, all channels together.
double TrueMachine::response(const std::vector<Channels>& still, const Background& background) const {
  const std::vector<Channels> moved = motion(train_, {.background = background}, kRoughTolerance);
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < moved.size(); ++i)
    for (std::size_t c = 0; c < moved[i].size(); ++c)
      for (std::size_t k = 0; k < moved[i][c].size(); ++k, ++count)
        sum += std::pow((moved[i][c][k] - still[i][c][k]) / experiment_.channels[c].noise, 2);
  return std::sqrt(sum / count);
}

/// Every joint's own changes the motion by as much, and all together leave what the options ask for.
void TrueMachine::add_background() {
  std::vector<double> sizes;
  for (int j = 0; j < plain_.dof(); ++j)
    sizes.push_back(kBackgroundShare * typical_size(Scale::effort, plain_, experiment_, j, values_));
  Background unit(sizes, plain_travel(), options_.seed);
  const std::vector<Channels> still = motion(train_, {}, kRoughTolerance);
  for (std::size_t j = 0; j < unit.joints(); ++j) {
    const double seen = response(still, unit.only(j));
    unit.scale(j, seen > kUnmoved ? 1.0 / seen : 0.0);
  }
  const double factor = factor_for(options_.imperfections.background, "the background", 0.0, [&](double tried) {
    return visibility({.background = unit.times(tried)}, kRoughTolerance).second;
  });
  background_ = unit.times(factor);
}

void TrueMachine::add_uneven() {
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    uneven_.emplace_back();
    if (hidden[k].along_the_way().empty()) continue;
    const int joint = *scenario_.robot->find_joint(hidden[k].asked().place);
    uneven_.back() = drawn_unevenness(options_.imperfections.uneven, joint, hidden[k].stage(), plain_travel(),
                                      RandomStream(options_.seed, 0, static_cast<std::uint32_t>(k), kUneven));
  }
  if (std::ranges::all_of(uneven_, [](const UnevenLaw& law) { return law.share == 0.0; }))
    throw InputError("--uneven", "no hidden law that could change along its way",
                     "an effect at a joint that acts on its command or its effort, and recordings that move it");
}

TrueLaws TrueMachine::laws() const {
  TrueLaws out{.outside = outside, .background = background_, .imperfect = true};
  for (const Hidden& effect : hidden) out.effects.push_back(effect.spec(1.0));
  out.effects.insert(out.effects.end(), misplaced_.begin(), misplaced_.end());
  return out;
}

const Travel& TrueMachine::plain_travel() {
  if (!plain_travel_) plain_travel_ = travel({});
  return *plain_travel_;
}

void TrueMachine::add(const HiddenEffect& asked, std::size_t index) {
  if (asked.outside) {
    add_outside(asked, index);
  } else {
    hidden.emplace_back(asked, plain_, experiment_, values_);
  }
}

/// N m (N), the command's unit, or s: enough to be seen, and what a visibility is scaled from.
double TrueMachine::typical_strength(OutsidePhysics::Kind kind, int joint) const {
  const OutsideInfo& info = info_of(kind);
  if (info.over == OutsideWay::time && info.stage != Stage::link) return 0.3;
  const Scale scale = info.over == OutsideWay::command ? Scale::command : Scale::effort;
  return 0.2 * typical_size(scale, plain_, experiment_, joint, values_);
}

void TrueMachine::add_outside(const HiddenEffect& asked, std::size_t index) {
  const std::string where = "--effect " + printable(asked.effect + ":" + asked.place, 80);
  const auto joint = scenario_.robot->find_joint(asked.place);
  if (!joint) throw InputError(where, "the place " + quoted(asked.place), "a joint");
  if (!asked.recordings.empty())
    throw InputError("--recordings", "with " + asked.effect,
                     "an effect that may act in some recordings only, as payload");
  OutsidePhysics physics{*asked.outside, *joint, typical_strength(*asked.outside, *joint)};
  for (const auto& [name, value] : asked.given) {
    if (!name.empty() && name != "strength") throw InputError(where, "the parameter " + quoted(name), "strength");
    physics.strength = value;
  }
  if (!(physics.strength > 0.0) || !std::isfinite(physics.strength))
    throw InputError(where, format_number(physics.strength), "a strength above 0");
  set_strength(physics, physics.strength);
  physics.times = drawn_times(index);
  if (physics.kind == OutsidePhysics::Kind::repeated_samples) begin_at_samples(physics.times);
  if (info_of(physics.kind).over != OutsideWay::time) {
    physics.form = drawn_form(physics, plain_travel(), *scenario_.robot,
                              RandomStream(options_.seed, 0, static_cast<std::uint32_t>(index), kForm), where);
  }
  outside.push_back(std::move(physics));
}

/// Samples repeat as wholes, at least one.
void TrueMachine::set_strength(OutsidePhysics& physics, double strength) const {
  physics.strength = strength;
  const double period = experiment_.sample_period;
  if (physics.kind == OutsidePhysics::Kind::repeated_samples)
    physics.strength = period * std::max(1.0, std::round(strength / period));
}

/// The first sample that a transducer does not take is the one from which it repeats.
void TrueMachine::begin_at_samples(std::vector<std::vector<double>>& times) const {
  for (const Segment& segment : experiment_.segments) {
    const std::vector<double>& clock = segment.commands->time;
    for (double& from : times[segment.recording]) from = *std::lower_bound(clock.begin(), clock.end() - 1, from);
  }
}

/// Three instants a recording, one in each third.
std::vector<std::vector<double>> TrueMachine::drawn_times(std::size_t index) const {
  std::vector<std::vector<double>> out(scenario_.recordings.size());
  for (const Segment& segment : experiment_.segments) {
    RandomStream stream(options_.seed, static_cast<std::uint32_t>(segment.recording), static_cast<std::uint32_t>(index),
                        kWhen);
    const double span = segment.time(segment.count - 1);
    for (int third = 0; third < 3; ++third)
      out[segment.recording].push_back(span * (third + stream.uniform(0.15, 0.85)) / 3.0);
  }
  return out;
}

}  // namespace lacuna
