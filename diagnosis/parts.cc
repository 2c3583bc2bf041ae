#include "diagnosis/parts.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "diagnosis/baseline.h"

namespace lacuna {
namespace {

constexpr double kMovedByOthers = 0.1;  ///< rms over that of what is missing: a hundredth of its energy

template <class Value>
void keep_joints(std::map<std::string, Value>& of, const std::set<std::string>& names) {
  std::erase_if(of, [&](const auto& entry) { return names.count(entry.first) == 0; });
}

/// The scenario of some joints: the others stand in the middle of their travel.
Scenario restricted(const Scenario& scenario, const Experiment& experiment, const std::vector<int>& joints) {
  Scenario out = scenario;
  std::vector<bool> fixed(experiment.joint_names.size(), true);
  for (const int j : joints) fixed[j] = false;
  out.robot = scenario.robot->with_joints_fixed(fixed, experiment.position_middle);
  std::set<std::string> names;
  for (const Joint& joint : out.robot->joints()) names.insert(joint.name);
  out.name = out.robot->joints().front().name;
  std::erase_if(out.actuators, [&](const ActuatorSpec& a) { return names.count(a.joint) == 0; });
  std::erase_if(out.effects, [&](const EffectSpec& e) { return names.count(e.place) == 0; });
  std::erase_if(out.events, [&](const EventSpec& e) { return names.count(e.joint) == 0; });
  for (auto& [kind, columns] : out.channels.of) keep_joints(columns, names);
  for (auto& [kind, levels] : out.noise) keep_joints(levels, names);
  out.motion.reset();  // what `compare` moves
  out.notes.clear();
  const PlantModel model(out);
  std::erase_if(out.identify, [&](const IdentifySpec& spec) { return model.matching(spec.name).empty(); });
  return out;
}

bool is_measured(const Scenario& scenario, const std::vector<int>& joints) {
  const auto positions = scenario.channels.of.find(ChannelKind::position);
  return positions != scenario.channels.of.end() && std::any_of(joints.begin(), joints.end(), [&](int j) {
           return positions->second.count(scenario.robot->joints()[j].name) > 0;
         });
}

/// [channel of the part]: which one of the whole machine's it is.
std::vector<std::size_t> channels_in(const Experiment& whole, const Experiment& part) {
  std::vector<std::size_t> out;
  for (const Channel& channel : part.channels) {
    const std::string& joint = part.joint_names[channel.joint];
    const auto at = std::find_if(whole.channels.begin(), whole.channels.end(), [&](const Channel& c) {
      return c.kind == channel.kind && whole.joint_names[c.joint] == joint;
    });
    out.push_back(static_cast<std::size_t>(at - whole.channels.begin()));
  }
  return out;
}

/// Values of the parameters that both have.
std::vector<double> by_name(const PlantModel& to, std::vector<double> values, const PlantModel& from,
                            const std::vector<double>& given) {
  for (std::size_t p = 0; p < given.size(); ++p) {
    const int at = to.find(from.parameters()[p].name);
    if (at >= 0) values[at] = given[p];
  }
  return values;
}

/// The scenario of one joint of a chain, with the values that were identified on the whole. Searched is what belongs to
/// the joint itself; the masses that it is loaded with do not.
Scenario alone(const Scenario& scenario, const Experiment& experiment, const CurrentModel& plain, int j) {
  const Scenario fitted = with_values(scenario, plain.model, plain.space.expand(plain.fit.point));
  Scenario out = restricted(fitted, experiment, {j});
  std::erase_if(out.identify, [&](const IdentifySpec& spec) {
    return plain.model.parameters()[plain.model.find(spec.name)].joint != j;
  });
  return out;
}

/// Weighed residual at a model's point on the train segments, whose starts are taken as exact.
struct PlainResidual {
  Eigen::VectorXd rows;
  std::vector<ResidualBlock> blocks;
};
PlainResidual plain_residual(const CurrentModel& model, const FitContext& context) {
  Experiment experiment = context.experiment;
  for (Segment& segment : experiment.segments) segment.start_effects = nullptr;
  const std::vector<int> train = experiment.with_role(Role::train);
  Problem problem = problem_of(model, context.on(experiment));
  return {problem.residual(model.fit.point, train), problem.layout(train)};
}

Eigen::VectorXd rows_of(const PlainResidual& residual, std::size_t channel) {
  Eigen::VectorXd out(residual.rows.size());
  Eigen::Index count = 0;
  for (const ResidualBlock& block : residual.blocks) {
    if (block.channel != static_cast<int>(channel)) continue;
    out.segment(count, block.count) = residual.rows.segment(block.first, block.count);
    count += block.count;
  }
  out.conservativeResize(count);
  return out;
}

/// Whether a part predicts of its channels what the whole machine does (`whole`), where the others move.
bool predicts_as_whole(const Scenario& part, const CurrentModel& plain, const PlainResidual& whole,
                       const FitContext& context) {
  const Experiment own_experiment = make_experiment(part);
  const CurrentModel own = part_of(plain, context.experiment, part, own_experiment);
  const PlainResidual residual = plain_residual(own, context.on(own_experiment));
  const std::vector<std::size_t> channels = channels_in(context.experiment, own_experiment);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const Eigen::VectorXd missing = rows_of(whole, channels[c]);
    if (!((rows_of(residual, c) - missing).norm() <= kMovedByOthers * missing.norm())) return false;
  }
  return true;
}

/// The parts of a chain whose drives each give a flow through stiff oil: a joint moves as it is told, whatever the
/// others do. Empty where that is not so of all of them.
std::vector<Scenario> parts_of_chain(const Scenario& scenario, const CurrentModel& plain,
                                     const std::vector<int>& joints, const FitContext& context) {
  std::vector<Scenario> out;
  for (const int j : joints) {
    if (!is_measured(scenario, {j})) continue;
    if (!integrates_flow(plain.model.actuators()[j].type)) return {};
    out.push_back(alone(scenario, context.experiment, plain, j));
  }
  const PlainResidual whole = plain_residual(plain, context);
  const auto stands = [&](const Scenario& part) { return predicts_as_whole(part, plain, whole, context); };
  if (!std::all_of(out.begin(), out.end(), stands)) out.clear();
  return out;
}

}  // namespace

std::vector<Scenario> parts_of(const Scenario& scenario, const CurrentModel& plain, const FitContext& context) {
  if (scenario.total_mass || has_effect_of_the_arm(plain.model)) return {};
  const bool efforts = std::holds_alternative<InverseDynamics>(context.experiment.prediction);
  const std::vector<int> branch = branches(plain.model);
  std::map<int, std::vector<int>> joints;
  for (std::size_t j = 0; j < branch.size(); ++j) joints[branch[j]].push_back(static_cast<int>(j));
  std::vector<Scenario> out;
  for (const auto& [first, those] : joints) {
    if (!is_measured(scenario, those)) continue;
    std::vector<Scenario> apart;
    if (those.size() > 1 && !efforts) apart = parts_of_chain(scenario, plain, those, context);
    if (apart.empty()) apart.push_back(restricted(scenario, context.experiment, those));
    std::move(apart.begin(), apart.end(), std::back_inserter(out));
  }
  if (out.size() < 2) out.clear();
  return out;
}

CurrentModel part_of(const CurrentModel& whole, const Experiment& experiment, const Scenario& part,
                     const Experiment& part_experiment) {
  const PlantModel model(part);
  CurrentModel out{model, SearchSpace(model, part), {}, {}};
  for (const std::size_t c : channels_in(experiment, part_experiment)) out.weights.push_back(whole.weights[c]);
  out.fit.point = out.space.contract(by_name(model, model.values(), whole.model, whole.space.expand(whole.fit.point)));
  return out;
}

CurrentModel put_together(const CurrentModel& whole, const std::vector<CurrentModel>& parts,
                          const std::vector<Experiment>& part_experiments, const FitContext& context) {
  CurrentModel out = whole;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::vector<std::size_t> channels = channels_in(context.experiment, part_experiments[k]);
    for (std::size_t c = 0; c < channels.size(); ++c) out.weights[channels[c]] = parts[k].weights[c];
    for (const EffectSpec& spec : effects_beyond(whole.model, parts[k]))
      out = extended(out, context.experiment, spec, out.fit.point, {});
  }
  std::vector<double> values = by_name(out.model, out.model.values(), whole.model, whole.space.expand(whole.fit.point));
  for (const CurrentModel& part : parts) {
    const std::vector<double> found = part.space.expand(part.fit.point);
    for (const Axis& axis : part.space.axes()) {
      const std::size_t p = axis.parameter;
      values[out.model.find(part.model.parameters()[p].name)] = found[p];
    }
  }
  evaluate_at(out, out.space.contract(values), context);
  return out;
}

}  // namespace lacuna
