#include "compare/motion.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "backends/engine.h"
#include "ga/random.h"
#include "physics/actuators/table.h"
#include "physics/effects/table.h"
#include "scenarios/error.h"
#include "scenarios/recording_check.h"

namespace lacuna {
namespace {

constexpr double kTurned = 1.0, kSlid = 0.1;  // rad, m: where joints start if nobody says
constexpr double kSpeed = 0.5;                // rad/s, m/s: drawn for a free motion that would start at rest
constexpr double kFreeDuration = 5.0;         // s, of a motion without commands
constexpr std::size_t kFewestIntervals = 32;  // of a motion without commands
constexpr std::uint32_t kSpeedDraws = 71;     // purpose of the random stream

bool changes_masses(const EffectSpec& spec) {
  const int type = find_effect(spec.effect);
  if (type < 0) return false;
  const Hooks<double>& hooks = Effects::hooks<double>()[type];
  return hooks.inertials != nullptr || hooks.gravity != nullptr;
}

/// Evenly spaced samples without commands.
std::shared_ptr<const CommandTrack> silent_track(double duration, std::size_t dof) {
  auto track = std::make_shared<CommandTrack>();
  const std::size_t intervals =
      std::max<std::size_t>(kFewestIntervals, static_cast<std::size_t>(std::ceil(duration / kFreeSpacing - 1e-9)));
  for (std::size_t k = 0; k <= intervals; ++k)
    track->time.push_back(duration * static_cast<double>(k) / static_cast<double>(intervals));
  track->value.assign(dof, std::vector<double>(track->time.size(), 0.0));
  return track;
}

Segment whole(std::shared_ptr<const CommandTrack> track, const std::string& file) {
  Segment segment;
  segment.file = file;
  segment.count = track->time.size();
  segment.commands = std::move(track);
  return segment;
}

/// The scenario with the commands that its motion names as its one recording; nothing else is read of it.
Scenario with_commands(const Scenario& scenario) {
  Scenario out = scenario;
  std::erase_if(out.channels.of, [](const auto& kind) { return kind.first != ChannelKind::command; });
  RecordingSpec spec;
  spec.file = scenario.motion->commands;
  spec.where = scenario.motion->where + ".commands";
  out.recordings = {spec};
  load_and_check_recordings(out);
  return out;
}

/// Commands and start of the recording.
Segment recorded_segment(const Scenario& scenario) {
  const RecordingSpec& spec = scenario.recordings.front();
  const bool measured = std::any_of(scenario.channels.of.begin(), scenario.channels.of.end(), [](const auto& kind) {
    return kind.first != ChannelKind::command && !kind.second.empty();
  });
  if (!measured) return whole(command_track(scenario, spec), spec.file);
  Scenario free_run = scenario;
  free_run.prediction = FreeRun{};
  Segment segment = make_experiment(free_run).segments.front();
  segment.measured.clear();
  return segment;
}

double value_or(const std::map<std::string, double>& values, const std::string& joint, double otherwise) {
  const auto at = values.find(joint);
  return at == values.end() ? otherwise : at->second;
}

/// The start as `motion` states it, or where nobody does the recording's, or a joint turned by a radian.
void set_start(const Scenario& scenario, Segment& segment) {
  const bool recorded = !segment.q0.empty();
  const bool nobody = !recorded && !scenario.motion;
  for (std::size_t j = 0; j < scenario.robot->joints().size(); ++j) {
    const Joint& joint = scenario.robot->joints()[j];
    double q = recorded ? segment.q0[j] : 0.0, v = recorded ? segment.v0[j] : 0.0;
    if (nobody) q = std::clamp(joint.prismatic() ? kSlid : kTurned, joint.lower, std::max(joint.lower, joint.upper));
    if (scenario.motion) {
      q = value_or(scenario.motion->position, joint.name, q);
      v = value_or(scenario.motion->velocity, joint.name, v);
    }
    if (!recorded) {
      segment.q0.push_back(q);
      segment.v0.push_back(v);
    } else {
      segment.q0[j] = q;
      segment.v0[j] = v;
    }
  }
}

void cut_after(Segment& segment, double seconds) {
  const double begin = segment.time(0);
  std::size_t count = 2;
  while (count < segment.count && segment.time(count) - begin <= seconds * (1.0 + 1e-9)) ++count;
  segment.count = std::min(segment.count, count);
}

PlantModel plant_of(const Scenario& scenario, bool pickup) {
  Scenario kept = scenario;
  std::erase_if(kept.effects, only_reads);
  PlantModel model(kept);
  if (pickup && model.find_effect_at("payload", "arm") < 0) {
    model = model.with_effects({EffectSpec{"payload", "arm", {}, {}, scenario.motion->where + ".pickup"}});
  }
  return model;
}

/// Splits the only phase at the instant of the pickup.
void add_pickup(const MotionSpec& spec, Motion& motion) {
  Phase& first = motion.phases.front();
  std::size_t at = 1;
  while (at + 1 < first.segment.count && first.segment.time(at) < spec.pickup_time) ++at;
  if (at + 2 > first.segment.count)
    throw InputError(spec.where + ".pickup.time", fmt::format("{} s", spec.pickup_time),
                     fmt::format("an instant within the motion of {} s", motion.duration()));
  Phase second = first;
  second.segment.first = first.segment.first + at;
  second.segment.count = first.segment.count - at;
  second.values[motion.model.find("arm.payload.m")] += *spec.pickup_mass;
  first.segment.count = at + 1;
  motion.phases.push_back(std::move(second));
}

void refuse_states(const Motion& motion, const std::string& where) {
  const auto holds = [](const auto& tables, const std::vector<Component>& components) {
    return std::any_of(components.begin(), components.end(), [&](const Component& c) {
      if (c.type < 0) return false;
      const auto& hooks = tables[c.type];
      return hooks.states > 0 || hooks.memories > 0;
    });
  };
  if (holds(Actuators::hooks<double>(), motion.model.actuators()) ||
      holds(Effects::hooks<double>(), motion.model.effects()))
    throw InputError(where, "a plant with states of its own, which a pickup would begin anew",
                     "actuators and effects without states");
}

std::string words_of(const Scenario& scenario, const Motion& motion) {
  std::string out = fmt::format("{:.4g} s", motion.duration());
  if (motion.commanded) {
    out += " of the commands in " + std::filesystem::path(motion.phases.front().segment.file).filename().string();
  } else {
    out +=
        scenario.motion ? " from the stated start" : " from every joint at 1 rad (0.1 m) or the nearest limit, at rest";
    if (!scenario.actuators.empty()) out += ", commands 0";
  }
  if (motion.phases.size() > 1)
    out += fmt::format("; at {:.4g} s the tool takes hold of {:.4g} kg at rest, the joints' momenta stay",
                       scenario.motion->pickup_time, *scenario.motion->pickup_mass);
  return out;
}

}  // namespace

bool only_reads(const EffectSpec& spec) {
  const int type = find_effect(spec.effect);
  if (type < 0) return false;  // the plant refuses it with a better message
  const Hooks<double>& hooks = Effects::hooks<double>()[type];
  return hooks.sense != nullptr && hooks.effort == nullptr && hooks.command == nullptr && hooks.dry_friction == nullptr;
}

double Motion::duration() const {
  const Segment& last = phases.back().segment;
  return last.time(last.count - 1) - phases.front().segment.time(0);
}

double Motion::longest_step() const {
  std::vector<double> gaps;
  for (const Phase& phase : phases) {
    for (std::size_t k = 0; k + 1 < phase.segment.count; ++k)
      gaps.push_back(phase.segment.time(k + 1) - phase.segment.time(k));
  }
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
  return gaps[gaps.size() / 2];
}

Motion Motion::first(double seconds) const {
  Motion out = *this;
  double left = seconds;
  out.phases.clear();
  for (const Phase& phase : phases) {
    out.phases.push_back(phase);
    Segment& segment = out.phases.back().segment;
    const double length = segment.time(segment.count - 1) - segment.time(0);
    if (length >= left) {
      cut_after(segment, left);
      break;
    }
    left -= length;
  }
  return out;
}

std::vector<double> Motion::times() const {
  std::vector<double> out;
  const double begin = phases.front().segment.time(0);
  for (const Phase& phase : phases) {
    for (std::size_t k = out.empty() ? 0 : 1; k < phase.segment.count; ++k)
      out.push_back(phase.segment.time(k) - begin);
  }
  return out;
}

Motion motion_of(const Scenario& given, double most) {
  if (given.robot->dof() == 0) throw InputError(given.file.string() + ": robot", "no joint that moves", "at least one");
  const Scenario scenario = given.motion && !given.motion->commands.empty() ? with_commands(given) : given;
  const bool pickup = scenario.motion && scenario.motion->pickup_mass;
  Motion out{plant_of(scenario, pickup), {}, false, {}};
  const bool stated = scenario.motion && scenario.motion->duration;
  double duration = stated ? *scenario.motion->duration : kFreeDuration;
  if (!stated) duration = std::min(duration, most);
  Phase phase;
  if (scenario.recordings.empty()) {
    phase.segment = whole(silent_track(duration, scenario.robot->joints().size()), "");
  } else {
    phase.segment = recorded_segment(scenario);
    out.commanded = true;
    cut_after(phase.segment, stated ? duration : most);
  }
  set_start(scenario, phase.segment);
  phase.values = out.model.values_in(phase.segment.file, out.model.values());
  out.phases.push_back(std::move(phase));
  if (pickup) {
    refuse_states(out, scenario.motion->where + ".pickup");
    add_pickup(*scenario.motion, out);
  }
  out.words = words_of(scenario, out);
  return out;
}

Motion free_motion_of(const Scenario& scenario, const Motion& motion, double seconds, bool gravity,
                      std::uint64_t seed) {
  Scenario bare = scenario;
  bare.actuators.clear();
  bare.motion.reset();
  std::erase_if(bare.effects, [](const EffectSpec& spec) { return !changes_masses(spec) || only_reads(spec); });
  if (!gravity) bare.gravity.setZero();
  Motion out{PlantModel(bare), {}, false, {}};
  Phase phase;
  phase.segment = whole(silent_track(seconds, scenario.robot->joints().size()), motion.phases.front().segment.file);
  phase.segment.q0 = motion.phases.front().segment.q0;
  phase.segment.v0 = motion.phases.front().segment.v0;
  const bool rests = std::all_of(phase.segment.v0.begin(), phase.segment.v0.end(), [](double v) { return v == 0.0; });
  RandomStream stream(seed, 0, 0, kSpeedDraws);
  for (double& v : phase.segment.v0) v = rests ? stream.uniform(-kSpeed, kSpeed) : v;
  phase.values = out.model.values_in(phase.segment.file, out.model.values());
  out.phases.push_back(std::move(phase));
  out.words = fmt::format("{:.4g} s of free motion{}", seconds, gravity ? "" : " without gravity");
  return out;
}

std::unique_ptr<Dynamics> build_engine(const std::string& engine, const Motion& motion) {
  const std::vector<double>& values = motion.phases.front().values;
  auto dynamics = find_engine(engine).build(motion.model.robot_ptr(), motion.model.gravity(values));
  const std::vector<Inertial> bodies = motion.model.inertials(values);
  for (int i = 0; i < motion.model.dof(); ++i) dynamics->set_inertial(i, bodies[i]);
  return dynamics;
}

std::vector<double> speeds_after_pickup(const PlantModel& model, const std::vector<double>& values_before,
                                        const std::vector<double>& values_after, const std::vector<double>& q,
                                        const std::vector<double>& v) {
  const auto dynamics = find_engine("featherstone").build(model.robot_ptr(), model.gravity(values_before));
  const auto mass_under = [&](const std::vector<double>& values) {
    const std::vector<Inertial> bodies = model.inertials(values);
    for (int i = 0; i < model.dof(); ++i) dynamics->set_inertial(i, bodies[i]);
    Eigen::MatrixXd mass;
    dynamics->mass_matrix(q, mass);
    const std::vector<double> armatures = model.armatures(values);
    for (int i = 0; i < model.dof(); ++i) mass(i, i) += armatures[i];
    return mass;
  };
  const Eigen::VectorXd momentum = mass_under(values_before) * Eigen::Map<const Eigen::VectorXd>(v.data(), v.size());
  const Eigen::VectorXd after = mass_under(values_after).llt().solve(momentum);
  return {after.data(), after.data() + after.size()};
}

}  // namespace lacuna
