#include "diagnosis/parts.h"

#include <algorithm>
#include <map>
#include <set>

#include "diagnosis/baseline.h"

namespace lacuna {
namespace {

/// The branches' joints with what rides on them, and all that stands still.
std::shared_ptr<const Robot> robot_of(const Robot& whole, const std::vector<int>& joints) {
  std::map<int, int> new_body{{-1, -1}};
  for (std::size_t k = 0; k < joints.size(); ++k) new_body[joints[k]] = static_cast<int>(k);
  std::map<int, int> new_link;
  std::vector<Link> links;
  for (std::size_t l = 0; l < whole.links().size(); ++l) {
    Link link = whole.links()[l];
    const auto body = new_body.find(link.body);
    if (body == new_body.end()) continue;
    new_link[static_cast<int>(l)] = static_cast<int>(links.size());
    link.body = body->second;
    links.push_back(std::move(link));
  }
  std::vector<Joint> kept;
  for (const int j : joints) {
    Joint joint = whole.joints()[static_cast<std::size_t>(j)];
    joint.parent = new_body.at(joint.parent), joint.link = new_link.at(joint.link);
    kept.push_back(std::move(joint));
  }
  return std::make_shared<const Robot>(whole.name(), std::move(kept), std::move(links), whole.name());
}

template <class Value>
void keep_joints(std::map<std::string, Value>& of, const std::set<std::string>& names) {
  std::erase_if(of, [&](const auto& entry) { return names.count(entry.first) == 0; });
}

Scenario restricted(const Scenario& scenario, const std::vector<int>& joints) {
  Scenario out = scenario;
  out.robot = robot_of(*scenario.robot, joints);
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
           return positions->second.count(scenario.robot->joints()[static_cast<std::size_t>(j)].name) > 0;
         });
}

/// [channel of the part]: which one of the whole machine's it is.
std::vector<std::size_t> channels_in(const Experiment& whole, const Experiment& part) {
  std::vector<std::size_t> out;
  for (const Channel& channel : part.channels) {
    const std::string& joint = part.joint_names[static_cast<std::size_t>(channel.joint)];
    const auto at = std::find_if(whole.channels.begin(), whole.channels.end(), [&](const Channel& c) {
      return c.kind == channel.kind && whole.joint_names[static_cast<std::size_t>(c.joint)] == joint;
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
    if (at >= 0) values[static_cast<std::size_t>(at)] = given[p];
  }
  return values;
}

}  // namespace

std::vector<Scenario> parts_of(const Scenario& scenario) {
  if (scenario.total_mass) return {};
  const std::vector<int> branch = branches(PlantModel(scenario));
  std::map<int, std::vector<int>> joints;
  for (std::size_t j = 0; j < branch.size(); ++j) joints[branch[j]].push_back(static_cast<int>(j));
  if (joints.size() < 2) return {};
  std::vector<Scenario> out;
  for (const auto& [first, those] : joints)
    if (is_measured(scenario, those)) out.push_back(restricted(scenario, those));
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

CurrentModel put_together(const CurrentModel& whole, const Experiment& experiment,
                          const std::vector<CurrentModel>& parts, const std::vector<Experiment>& part_experiments,
                          const SimulatorOptions& simulator) {
  CurrentModel out = whole;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::vector<std::size_t> channels = channels_in(experiment, part_experiments[k]);
    for (std::size_t c = 0; c < channels.size(); ++c) out.weights[channels[c]] = parts[k].weights[c];
    for (const EffectSpec& spec : effects_beyond(whole.model, parts[k]))
      out = extended(out, experiment, spec, out.fit.point, {});
  }
  std::vector<double> values = by_name(out.model, out.model.values(), whole.model, whole.space.expand(whole.fit.point));
  for (const CurrentModel& part : parts)
    values = by_name(out.model, std::move(values), part.model, part.space.expand(part.fit.point));
  evaluate_at(out, out.space.contract(values), experiment, simulator);
  return out;
}

}  // namespace lacuna
