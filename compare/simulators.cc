#include "compare/simulators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenarios/error.h"
#include "compare/motion.h"

namespace lacuna {
namespace {

constexpr double kLeastOrder = 0.5, kMostOrder = 4.0;
constexpr double kGone = 0.5, kStays = 0.8;  // of the energy beyond the noise that is left at half the step
constexpr double kNothing = 0.1;             // of the noise: a rest that is none

bool damps_its_joint(const ActuatorSpec& spec) {
  return spec.model == "torque_source" || spec.model == "direct_effort";
}

double command_rms(const Scenario& scenario, const std::string& joint) {
  const auto commands = scenario.channels.of.find(ChannelKind::command);
  if (commands == scenario.channels.of.end()) return 0.0;
  const auto column = commands->second.find(joint);
  if (column == commands->second.end()) return 0.0;
  double sum = 0.0, count = 0.0;
  for (const RecordingSpec& spec : scenario.recordings) {
    if (!spec.data) continue;
    const int at = spec.data->find(column->second.column);
    if (at < 0) continue;
    for (const double u : spec.data->columns[at]) {
      const double value = column->second.scale * u + column->second.offset;
      if (std::isfinite(value)) sum += value * value, count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

/// Takes damping and stated friction out of the scenario into the losses.
void take_losses(NativePlant& plant) {
  Scenario& scenario = plant.scenario;
  for (ActuatorSpec& spec : scenario.actuators) {
    const auto damping = spec.parameters.find("damping");
    if (damping == spec.parameters.end() || !damps_its_joint(spec)) continue;
    const std::size_t joint = *scenario.robot->find_joint(spec.joint);
    plant.losses[joint].damping = damping->second;
    plant.given.emplace_back(spec.joint + ".damping", damping->second);
    damping->second = 0.0;
  }
  for (const EffectSpec& effect : scenario.effects) {
    const auto joint = scenario.robot->find_joint(effect.place);
    const auto bound = effect.parameters.find("Fc");
    if (effect.effect == "coulomb_friction" && joint && bound != effect.parameters.end())
      plant.losses[*joint].friction = bound->second;
  }
  std::erase_if(scenario.effects, [](const EffectSpec& effect) { return effect.effect == "coulomb_friction"; });
  std::erase_if(scenario.effects, only_reads);
  scenario.events.clear();
}

double rms(double sum, std::size_t count) { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0; }

/// Sums of squares of the differences h - h/2 and h/2 - h/4 of one joint.
std::pair<double, double> difference_energies(std::span<const Trajectory> runs, std::size_t joint) {
  double first = 0.0, second = 0.0;
  for (std::size_t k = 0; k < runs[0].q.size(); ++k) {
    const double a = runs[0].q[k][joint] - runs[1].q[k][joint], b = runs[1].q[k][joint] - runs[2].q[k][joint];
    first += a * a, second += b * b;
  }
  return {first, second};
}

const FoundNumber* find(const SimulatorSide& side, const std::string& name) {
  const auto at = std::ranges::find_if(side.numbers, [&](const FoundNumber& n) { return n.name == name; });
  return at == side.numbers.end() ? nullptr : &*at;
}

/// "joint_2.coulomb_friction.Fc": numbers of effects have a part more than those of the plain model.
bool of_effect(const std::string& name) { return std::ranges::count(name, '.') >= 2; }

double given_of(std::span<const std::pair<std::string, double>> given, const std::string& name) {
  const auto at = std::ranges::find_if(given, [&](const auto& entry) { return entry.first == name; });
  return at == given.end() ? kUnmeasured : at->second;
}

}  // namespace

NativePlant native_plant(const Scenario& scenario, double friction_share) {
  if (!(friction_share >= 0.0) || !std::isfinite(friction_share))
    throw InputError("--own-friction", fmt::format("{:g}", friction_share), "a share from 0");
  NativePlant out{scenario, {}, {}};
  out.losses.resize(scenario.robot->joints().size());
  const PlantModel model(scenario);
  for (const Parameter& parameter : model.parameters())
    if (!of_effect(parameter.name) && !parameter.name.ends_with(".damping"))
      out.given.emplace_back(parameter.name, parameter.value);
  take_losses(out);
  const bool stated = std::ranges::any_of(out.losses, [](const JointLoss& loss) { return loss.friction > 0.0; });
  for (const ActuatorSpec& spec : scenario.actuators) {
    const auto gain = spec.parameters.find("gain");
    if (stated || gain == spec.parameters.end() || !damps_its_joint(spec)) continue;
    out.losses[*scenario.robot->find_joint(spec.joint)].friction =
        friction_share * std::fabs(gain->second) * command_rms(scenario, spec.joint);
  }
  for (std::size_t j = 0; j < out.losses.size(); ++j)
    out.given.emplace_back(scenario.robot->joints()[j].name + ".coulomb_friction.Fc", out.losses[j].friction);
  return out;
}

Trajectory record_natively(const NativePlant& plant, const Scenario& one_recording, const NativeMethod& method,
                           double step) {
  Scenario scenario = plant.scenario;
  scenario.recordings = one_recording.recordings;
  scenario.channels = one_recording.channels;
  scenario.motion.reset();
  scenario.recordings.front().from.reset(), scenario.recordings.front().to.reset();
  const Motion motion = motion_of(scenario, std::numeric_limits<double>::infinity());
  Runner runner(method.engine, motion);
  const Method own{method.integrator, true};
  if (const std::string why = runner.refuses(own); !why.empty())
    throw WorkError("engine " + method.engine + " cannot make recordings of this plant by its own steps: " + why);
  runner.set_own_losses(plant.losses);
  Trajectory out = runner.run(own, step);
  for (const std::vector<double>& q : out.q)
    for (const double x : q)
      if (!std::isfinite(x))
        throw WorkError(
            fmt::format("engine {} diverges by its own steps of {:g} s: a shorter --step", method.engine, step));
  return out;
}

std::vector<StepDependence> step_dependence(const Robot& robot, std::span<const Trajectory> runs) {
  std::vector<StepDependence> out;
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const Joint& joint = robot.joints()[j];
    StepDependence one{joint.name, joint.prismatic() ? "m" : "rad", kUnmeasured, 0.0, 0.0};
    const auto [first, second] = difference_energies(runs, j);
    const double order = 0.5 * std::log2(first / second);
    if (order >= kLeastOrder && order <= kMostOrder) one.order = order;
    const double factor = std::exp2(std::isfinite(one.order) ? one.order : 1.0) - 1.0;
    double at_step = 0.0, at_half = 0.0;
    for (std::size_t k = 0; k < runs[0].q.size(); ++k) {
      const double finest = runs[2].q[k][j], zero = finest + (finest - runs[1].q[k][j]) / factor;
      at_step += std::pow(runs[0].q[k][j] - zero, 2), at_half += std::pow(runs[1].q[k][j] - zero, 2);
    }
    one.error_at_step = rms(at_step, runs[0].q.size()), one.error_at_half = rms(at_half, runs[0].q.size());
    out.push_back(one);
  }
  return out;
}

std::vector<StepDependence> pooled(std::span<const std::vector<StepDependence>> recordings) {
  std::vector<StepDependence> out = recordings.front();
  for (std::size_t j = 0; j < out.size(); ++j) {
    double at_step = 0.0, at_half = 0.0;
    std::vector<double> orders;
    for (const std::vector<StepDependence>& one : recordings) {
      at_step += std::pow(one[j].error_at_step, 2), at_half += std::pow(one[j].error_at_half, 2);
      if (std::isfinite(one[j].order)) orders.push_back(one[j].order);
    }
    std::ranges::sort(orders);
    out[j].order = orders.empty() ? kUnmeasured : orders[orders.size() / 2];
    out[j].error_at_step = rms(at_step, recordings.size()), out[j].error_at_half = rms(at_half, recordings.size());
  }
  return out;
}

const char* to_string(Origin origin) {
  switch (origin) {
    case Origin::as_built: return "as_built";
    case Origin::integrator: return "integrator";
    case Origin::physics: return "physics";
    default: return "both";
  }
}

std::vector<SimulatorNumber> tell_apart(const SimulatorSide& step, const SimulatorSide& half,
                                        std::span<const std::pair<std::string, double>> given, double order) {
  std::vector<std::string> names;
  for (const SimulatorSide* side : {&step, &half})
    for (const FoundNumber& number : side->numbers)
      if (std::ranges::find(names, number.name) == names.end()) names.push_back(number.name);
  const double factor = std::exp2(order) - 1.0;
  std::vector<SimulatorNumber> out;
  for (const std::string& name : names) {
    const FoundNumber *a = find(step, name), *b = find(half, name);
    if ((a == nullptr || b == nullptr) && !of_effect(name)) continue;
    SimulatorNumber one;
    one.name = name, one.unit = (a != nullptr ? a : b)->unit;
    one.given = given_of(given, name);
    one.at_step = a != nullptr ? a->value : 0.0, one.at_half = b != nullptr ? b->value : 0.0;
    one.at_zero = one.at_half + (one.at_half - one.at_step) / factor;
    const double wide_a = a != nullptr ? a->half_width : b->half_width, wide_b = b != nullptr ? b->half_width : wide_a;
    one.uncertainty = wide_a;
    one.integrator = one.at_step - one.at_zero, one.physics = one.at_zero - one.given;
    // The sides share their noise, so this overstates what the extrapolation is worth: nothing is claimed too soon.
    const double of_zero = std::hypot((1.0 + 1.0 / factor) * wide_b, wide_a / factor);
    const bool moves = std::fabs(one.integrator) > wide_a, stays = std::fabs(one.physics) > of_zero;
    one.origin = moves && stays ? Origin::both
                 : moves        ? Origin::integrator
                 : stays        ? Origin::physics
                                : Origin::as_built;
    out.push_back(std::move(one));
  }
  return out;
}

Origin origin_of_rest(double noise, double at_step, double at_half) {
  const auto beyond = [&](double all) { return std::max(0.0, all * all - noise * noise); };
  const double least = std::pow(kNothing * noise, 2) + 2.0 * kNothing * noise * noise;  // rms a tenth above the noise
  const double a = beyond(at_step), b = beyond(at_half);
  if (a <= least && b <= least) return Origin::as_built;
  if (b >= kStays * a) return Origin::physics;
  return b <= kGone * a ? Origin::integrator : Origin::both;
}

}  // namespace lacuna
