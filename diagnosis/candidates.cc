#include "diagnosis/candidates.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "physics/actuators/table.h"
#include "physics/effects/table.h"

namespace lacuna {
namespace {

/// Search ranges of an effect's own parameters, in typical sizes: wide enough for any arm, narrow enough to stay
/// finite.
constexpr double kWidest = 1e3;
constexpr double kFurthest = 5.0;         ///< place of a load, in tenths of the arm's length
constexpr double kJustBeyond = 1.05;      ///< of half the travel: furthest place of a stop
constexpr double kShortestTime = 0.5;     ///< s, longest delay searched
constexpr double kTraceOfCommand = 0.05;  ///< of a joint's largest command: below it the joint is not commanded

bool moves_under_command(const Experiment& experiment, int joint) { return experiment.command_rms[joint] > 0.0; }

bool has_channel(const Experiment& experiment, ChannelKind kind, int joint) {
  return std::any_of(experiment.channels.begin(), experiment.channels.end(),
                     [&](const Channel& c) { return c.kind == kind && c.joint == joint; });
}

/// Whether anything that is compared lies behind the stage at which an effect of the catalogue acts on joint j. By
/// inverse dynamics an effort is explained from the motion back: what stands before it in the chain has had its say in
/// the measurement, what reads the motion was taken as it is, and what lies between two sides shows in the actuator's.
bool shows(const EffectInfo& info, const Experiment& experiment, int j) {
  if (!std::holds_alternative<InverseDynamics>(experiment.prediction)) return !info.in_efforts;
  if (!has_channel(experiment, ChannelKind::effort, j) && !has_channel(experiment, ChannelKind::command, j))
    return false;
  switch (info.stage) {
    case Stage::link: return true;
    case Stage::transmission: return info.in_efforts || has_channel(experiment, ChannelKind::motor_position, j);
    default: return false;
  }
}

/// Whether an effect can act at joint j at all: on a command or an actuator where there is one, on a motion where it is
/// measured and moves.
bool can_act(const EffectInfo& info, const Hooks<double>& hooks, const CurrentModel& current,
             const Experiment& experiment, int j) {
  if (!shows(info, experiment, j)) return false;
  const bool driven = current.model.actuators()[j].type >= 0 && moves_under_command(experiment, j);
  if (hooks.command != nullptr || hooks.delay != nullptr) return driven;
  return driven || experiment.position_rms[j] > 0.0;
}

/// Index in the table of joint j's actuator, or -1.
int drive_of(const CurrentModel& current, int j) { return current.model.actuators()[j].type; }
/// Whether joint j's actuator stands for a valve and a cylinder.
bool is_hydraulic(const CurrentModel& current, int j) {
  const int type = drive_of(current, j);
  return type >= 0 && actuator_table()[type].hydraulic;
}

/// Whether two joints are ever commanded at once in what is fitted, each by more than a trace of its largest command:
/// only then can one be seen to take from the other, where a single one at its limit shows a limit of its own.
bool commanded_at_once(const Experiment& experiment) {
  const std::size_t joints = experiment.joint_names.size();
  std::vector<double> largest(joints, 0.0);
  const auto train = experiment.with_role(Role::train);
  const auto command = [&](int s, std::size_t j, std::size_t k) {
    const Segment& segment = experiment.segments[s];
    return std::fabs(segment.commands->value[j][segment.first + k]);
  };
  const auto each = [&](const auto& visit) {
    for (const int s : train)
      for (std::size_t k = 0; k < experiment.segments[s].count; ++k) visit(s, k);
  };
  each([&](int s, std::size_t k) {
    for (std::size_t j = 0; j < joints; ++j) largest[j] = std::max(largest[j], command(s, j, k));
  });
  std::size_t at_once = 0;
  each([&](int s, std::size_t k) {
    int moved = 0;
    for (std::size_t j = 0; j < joints; ++j) moved += command(s, j, k) > kTraceOfCommand * largest[j];
    at_once += moved > 1;
  });
  return at_once > 0;
}

}  // namespace

Problem problem_of(const CurrentModel& model, const FitContext& context, std::vector<double> weights) {
  return {model.model, context.experiment, model.space, context.simulator, std::move(weights)};
}

Problem problem_of(const CurrentModel& model, const FitContext& context) {
  return problem_of(model, context, model.weights);
}

std::vector<EffectSpec> places_of(const EffectInfo& info, const CurrentModel& current, const Experiment& experiment) {
  std::vector<EffectSpec> out;
  if (info.learned) return out;
  const Hooks<double>& hooks = Effects::hooks<double>()[find_effect(info.name)];
  if (info.where == Where::arm) {
    bool any = false;
    if (experiment.parts > 1) return out;
    for (int j = 0; j < current.model.dof(); ++j)
      any = any || ((!info.hydraulic || (is_hydraulic(current, j) && moves_under_command(experiment, j))) &&
                    shows(info, experiment, j));
    if (info.shares && any) any = commanded_at_once(experiment);
    const bool base_moves = hooks.base != nullptr;  // which a measured motion of the joints does not show
    if (any && !(base_moves && std::holds_alternative<InverseDynamics>(experiment.prediction)))
      out.push_back({info.name, "arm", {}, {}, info.name});
  } else {
    for (int j = 0; j < current.model.dof(); ++j) {
      if (!can_act(info, hooks, current, experiment, j) || (info.hydraulic && !is_hydraulic(current, j))) continue;
      if (info.metering && !lets_flow(drive_of(current, j))) continue;
      if (!suits(find_effect(info.name), drive_of(current, j))) continue;
      out.push_back({info.name, experiment.joint_names[j], form_of(info, current.model, experiment, j), {}, info.name});
    }
  }
  std::erase_if(out, [&](const EffectSpec& s) { return current.model.find_effect_at(s.effect, s.place) >= 0; });
  return out;
}

std::map<std::string, double> form_of(const EffectInfo& info, const PlantModel& model, const Experiment& experiment,
                                      int joint) {
  std::map<std::string, double> out;
  for (const ParameterInfo& p : info.parameters)
    if (p.structural) out[p.name] = typical_size(p.scale, model, experiment, joint, model.values());
  return out;
}

std::vector<Axis> effect_axes(const PlantModel& model, const Experiment& experiment, const Component& component,
                              const EffectSpec& spec) {
  std::vector<Axis> axes;
  for (int k = 0; k < component.count; ++k) {
    const int index = component.first + k;
    const Parameter& p = model.parameters()[index];
    if (p.info->structural || spec.parameters.count(p.key) > 0) continue;
    const double size = typical_size(p.info->scale, model, experiment, p.joint, model.values());
    Axis axis{index, p.lower, p.upper, p.value, p.info->coordinate};
    if (axis.coordinate == Coordinate::inverse) {
      axis.lower = std::isfinite(p.upper) ? 1.0 / p.upper : 0.0;
      axis.upper = std::min(1.0 / p.lower, kWidest / size);
      axis.start = 1.0 / p.value;
    } else if (axis.coordinate == Coordinate::logarithm) {
      axis.lower = std::log(std::max(p.lower, size / kWidest));
      axis.upper = std::log(std::min(p.upper, kWidest * size));
      axis.start = std::clamp(std::log(p.value), axis.lower, axis.upper);
    } else if (p.info->scale == Scale::time) {
      axis.upper = std::min(p.upper, kShortestTime);
    } else if (p.info->scale == Scale::inertia) {
      axis.upper = std::min(p.upper, kWidest * std::max(size, driven_inertia(model, experiment, p.joint)));
    } else if (p.info->scale == Scale::reach) {
      // Within the travel: a stop beyond it is never met, and one met all the way is none. A hard one lies at its end.
      const double middle = typical_origin(p.info->scale, experiment, p.joint);
      axis.lower = std::max(p.lower, middle - kJustBeyond * size);
      axis.upper = std::min(p.upper, middle + kJustBeyond * size);
    } else if (p.info->scale == Scale::wave) {
      axis.lower = std::max(p.lower, size);  // what does not come back within the travel repeats nothing
    } else if (p.info->scale == Scale::length) {
      const double most = p.info->optional ? kFurthest * size : size;  // what is carried may reach out further
      axis.lower = std::max(p.lower, -most);
      axis.upper = std::min(p.upper, most);
    } else {
      // What must stay positive starts at a thousandth of its size, below any resolution.
      axis.lower = std::max(p.lower, p.info->optional ? 1e-3 * size : -kWidest * size);
      axis.upper = std::min(p.upper, kWidest * size);
    }
    axes.push_back(axis);
  }
  return axes;
}

std::vector<std::vector<double>> starting_points(const PlantModel& model, const Experiment& experiment,
                                                 const std::vector<Axis>& axes) {
  const auto parameter = [&](const Axis& a) -> const Parameter& { return model.parameters()[a.parameter]; };
  std::vector<std::vector<double>> starts{{}};
  for (std::size_t first = 0, last = 0; first < axes.size(); first = last) {
    const ParameterInfo* info = parameter(axes[first]).info;
    while (last < axes.size() && parameter(axes[last]).info == info) ++last;
    std::vector<std::vector<double>> grown;
    for (const auto& start : starts) {
      for (const double factor : info->starts) {
        grown.push_back(start);
        for (std::size_t a = first; a < last; ++a) {
          const int joint = parameter(axes[a]).joint;
          const double size = typical_size(info->scale, model, experiment, joint, model.values());
          const double value = typical_origin(info->scale, experiment, joint) + factor * size;
          grown.back().push_back(to_search(info->coordinate, value));
        }
      }
    }
    starts = std::move(grown);
  }
  return starts;
}

CurrentModel extended(const CurrentModel& current, const Experiment& experiment, const EffectSpec& spec,
                      const std::vector<double>& point, const std::vector<double>& own) {
  CurrentModel out{current.model.with_effects({spec}), current.space, current.weights, {}};
  const std::vector<Axis> axes = effect_axes(out.model, experiment, out.model.effects().back(), spec);
  out.space.hold(out.model);
  for (const Axis& axis : axes) out.space.add(out.model, axis);
  out.fit.point = point;
  for (std::size_t k = 0; k < own.size(); ++k)
    out.fit.point.push_back(std::clamp(own[k], axes[k].lower, axes[k].upper));
  return out;
}

namespace {

/// A drive that integrates its flow takes up no more of it against such an effect: however soft that is, it is not
/// pushed through.
bool yields_no_more(const PlantModel& model, int parameter) {
  const int joint = model.parameters()[parameter].joint;
  if (joint < 0) return false;
  const Component& drive = model.actuators()[joint];
  if (!integrates_flow(drive.type)) return false;
  return std::any_of(model.effects().begin(), model.effects().end(), [&](const Component& effect) {
    return effect.first <= parameter && parameter < effect.first + effect.count &&
           Effects::hooks<double>()[effect.type].taken != nullptr;
  });
}

}  // namespace

bool is_large_enough(const CurrentModel& current, const Experiment& experiment, const Axis& axis, double x) {
  const Parameter& p = current.model.parameters()[axis.parameter];
  if (p.info == nullptr || !(p.info->least > 0.0) || yields_no_more(current.model, axis.parameter)) return true;
  const double size = typical_size(p.info->scale, current.model, experiment, p.joint, current.model.values());
  return std::fabs(axis.value(x)) >= p.info->least * size;
}

std::vector<EffectSpec> effects_beyond(const PlantModel& plain, const CurrentModel& current) {
  std::set<int> searched;
  for (const Axis& axis : current.space.axes()) searched.insert(axis.parameter);
  const std::vector<double> values = current.space.expand(current.fit.point);
  std::vector<EffectSpec> out;
  for (const Component& effect : current.model.effects()) {
    EffectSpec spec{effect_table()[effect.type].name, current.model.place_name(effect), {}, effect.recordings, ""};
    if (plain.find_effect_at(spec.effect, spec.place) >= 0) continue;
    for (int p = effect.first; p < effect.first + effect.count; ++p) {
      if (searched.count(p) == 0) spec.parameters[current.model.parameters()[p].key] = values[p];
    }
    out.push_back(std::move(spec));
  }
  return out;
}

}  // namespace lacuna
