#include "physics/plant_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "physics/effects/learned_curve.h"
#include "physics/effects/table.h"
#include "physics/units.h"
#include "scenarios/error.h"
#include "scenarios/text.h"

namespace lacuna {
namespace {

std::string names_of(const std::vector<EffectParameter>& parameters) {
  std::string text;
  for (const EffectParameter& p : parameters) text += (text.empty() ? "" : ", ") + p.key;
  return text;
}

template <class Info>
std::string names_of_table(const std::vector<Info>& table) {
  std::string text;
  for (const Info& info : table) text += (text.empty() ? "" : ", ") + std::string(info.name);
  return text;
}

void check_keys(const std::map<std::string, double>& given, const std::vector<EffectParameter>& parameters,
                const std::string& where, const std::string& owner) {
  for (const auto& [key, value] : given) {
    const bool known =
        std::any_of(parameters.begin(), parameters.end(), [&](const EffectParameter& p) { return key == p.key; });
    if (!known) throw InputError(where, "parameter " + quoted(key), owner + " takes " + names_of(parameters));
  }
}

double checked(const EffectParameter& parameter, const std::map<std::string, double>& given, const std::string& where,
               const std::string& owner) {
  const ParameterInfo& info = *parameter.info;
  const auto it = given.find(parameter.key);
  const double value = it == given.end() ? info.neutral : it->second;
  if (std::isnan(value)) throw InputError(where, "no " + parameter.key, owner + " needs " + info.meaning);
  if (value < info.lower || value > info.upper) {
    throw InputError(where, fmt::format("{} = {}", parameter.key, value),
                     fmt::format("a value from {} to {} {}", info.lower, info.upper, info.unit));
  }
  return value;
}

/// No parameter of the component below the one that bounds it (ParameterInfo::at_least).
void check_order(const std::vector<EffectParameter>& parameters, std::span<const Parameter> values,
                 const std::string& where) {
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const char* bound = parameters[k].info->at_least;
    if (bound == nullptr) continue;
    const auto other = std::find_if(values.begin(), values.end(), [&](const Parameter& p) { return p.key == bound; });
    if (other == values.end() || values[k].value >= other->value) continue;
    throw InputError(where, fmt::format("{} = {} {}", values[k].key, values[k].value, values[k].unit),
                     fmt::format("at least {} = {} {}", bound, other->value, other->unit));
  }
}

/// The robot with two joints under its base, about x, then y. What they move beside it is of no weight (Foundation adds
/// the base's inertia): a thousandth of the arm's mass, in the axes.
std::shared_ptr<const Robot> on_two_hinges(const Robot& robot) {
  constexpr int kHinges = 2;
  constexpr double kShare = 1e-3, kRadius = 1e-2;  // m
  std::vector<Joint> joints;
  std::vector<Link> links;
  for (int i = 0; i < kHinges; ++i) {
    const std::string name = i == 0 ? "base_compliance.roll" : "base_compliance.pitch";
    Joint joint;
    joint.name = name;
    joint.type = JointType::continuous;
    joint.parent = i - 1;
    joint.link = i;
    joint.axis = i == 0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
    joints.push_back(joint);
    Link link;
    link.name = name + ".link";
    link.body = i;
    link.inertial.mass = kShare * robot.moving_mass();
    link.inertial.inertia = Eigen::Matrix3d::Identity() * link.inertial.mass * kRadius * kRadius;
    links.push_back(link);
  }
  for (Joint joint : robot.joints()) {
    joint.parent += kHinges;  // the world's -1 becomes the upper hinge
    joint.link += kHinges;
    joints.push_back(joint);
  }
  for (Link link : robot.links()) {
    if (link.body >= 0) link.body += kHinges;
    links.push_back(link);
  }
  return std::make_shared<const Robot>(robot.name(), std::move(joints), std::move(links), robot.name());
}

}  // namespace

std::vector<EffectParameter> effect_parameters(const EffectInfo& info, const Robot& robot, int joint, int knots) {
  std::vector<EffectParameter> out;
  for (const ParameterInfo& p : info.parameters) {
    if (!p.per_joint && !p.per_knot) out.push_back({p.name, &p, joint});
  }
  for (const ParameterInfo& p : info.parameters) {
    if (!p.per_knot) continue;
    for (int k = 1; k <= knots; ++k) out.push_back({fmt::format("{}_{}", p.name, k), &p, joint});
  }
  for (const ParameterInfo& p : info.parameters) {
    if (!p.per_joint) continue;
    for (int j = 0; j < robot.dof(); ++j) out.push_back({p.name + ("_" + robot.joints()[j].name), &p, j});
  }
  return out;
}

PlantModel::PlantModel(const Scenario& scenario)
    : robot_(scenario.robot),
      moving_robot_(robot_),
      gravity_(scenario.gravity),
      mass_parameter_(robot_->links().size(), -1),
      actuators_(robot_->dof()) {
  for (const Joint& joint : robot_->joints()) command_units_.push_back(lacuna::command_unit(scenario, joint.name));
  for (std::size_t i = 0; i < actuators_.size(); ++i) actuators_[i].joint = static_cast<int>(i);
  for (const ActuatorSpec& spec : scenario.actuators) add_actuator(spec);
  for (std::size_t i = 0; i < robot_->links().size(); ++i) {
    const Link& link = robot_->links()[i];
    if (link.body < 0 || link.inertial.mass <= 0.0) continue;
    mass_parameter_[i] = static_cast<int>(parameters_.size());
    parameters_.push_back(
        {link.name + ".mass", "kg", link.inertial.mass, link.inertial.mass, 1e-9, 1e9, nullptr, "mass"});
  }
  for (const EffectSpec& spec : scenario.effects) add_effect(spec);
}

PlantModel PlantModel::with_effects(const std::vector<EffectSpec>& specs) const {
  PlantModel out = *this;
  for (const EffectSpec& spec : specs) out.add_effect(spec);
  return out;
}

void PlantModel::add_actuator(const ActuatorSpec& spec) {
  const int type = find_actuator(spec.model);
  if (type < 0) {
    throw InputError(spec.where, "model " + quoted(spec.model), "one of " + names_of_table(actuator_table()));
  }
  const ActuatorInfo& info = actuator_table()[type];
  const int joint = robot_->find_joint(spec.joint).value();
  std::vector<EffectParameter> parameters;
  for (const ParameterInfo& p : info.parameters) parameters.push_back({p.name, &p, joint});
  check_keys(spec.parameters, parameters, spec.where, spec.model);
  const bool prismatic = robot_->joints()[joint].prismatic();
  Component& component = actuators_[joint];
  component = {type, joint, static_cast<int>(parameters_.size()), static_cast<int>(parameters.size()), {}};
  for (const EffectParameter& p : parameters) {
    const double value = checked(p, spec.parameters, spec.where, spec.model);
    parameters_.push_back({spec.joint + "." + p.key, unit_at(p.info->unit, prismatic, command_unit(joint)), value,
                           value, p.info->lower, p.info->upper, p.info, p.key, joint});
  }
  check_order(parameters, std::span(parameters_).last(parameters.size()), spec.where);
}

/// How often the effect stands at its place already, each time in other recordings; an error otherwise.
int PlantModel::count_apart(const EffectSpec& spec) const {
  int out = 0;
  for (const Component& c : effects_) {
    if (effect_table()[c.type].name != spec.effect || place_name(c) != spec.place) continue;
    ++out;
    const bool apart =
        !c.recordings.empty() && !spec.recordings.empty() &&
        std::none_of(c.recordings.begin(), c.recordings.end(), [&](const std::string& file) {
          return std::find(spec.recordings.begin(), spec.recordings.end(), file) != spec.recordings.end();
        });
    if (!apart)
      throw InputError(spec.where, spec.effect + " at " + spec.place + " twice",
                       "each effect once at a place, or in different recordings");
  }
  return out;
}

namespace {

double given(const EffectSpec& spec, const std::string& key, double otherwise) {
  const auto at = spec.parameters.find(key);
  return at == spec.parameters.end() ? otherwise : at->second;
}

/// Values that a learned effect has; what cannot be is refused later, with the effect's own place.
int values_of(const EffectSpec& spec) {
  const double values = given(spec, "knots", 0.0) * std::max(given(spec, "knots_2", 0.0), 1.0);
  return static_cast<int>(std::clamp(values, 0.0, 1.0 * kMostValues));
}

/// A variable has no knots, or so many from one place to a later one; it is a joint's own or another's.
void check_variable(const EffectSpec& spec, const std::string& suffix, double fewest, int joints) {
  const double knots = given(spec, "knots" + suffix, 0.0), of = given(spec, "of" + suffix, 0.0);
  const double over = given(spec, "over" + suffix, 0.0);
  if (knots == 0.0) return;
  if (!(knots >= fewest) || knots != std::floor(knots))
    throw InputError(spec.where, fmt::format("{} knots", knots), fmt::format("a whole number from {}", fewest));
  if (!(given(spec, "from" + suffix, 0.0) < given(spec, "to" + suffix, 1.0)))
    throw InputError(
        spec.where,
        fmt::format("knots from {} to {}", given(spec, "from" + suffix, 0.0), given(spec, "to" + suffix, 1.0)),
        "from before to");
  if (over != std::floor(over)) throw InputError(spec.where, fmt::format("over {}", over), "a whole number");
  if (of != std::floor(of) || of > joints || (of > 0.0 && over > 1.0))
    throw InputError(spec.where, fmt::format("of {}", of), "0, or the number of a joint with its position or speed");
}

/// A learned law of one variable or two.
void check_knots(const EffectSpec& spec, int joints) {
  constexpr double kFewestKnots = 4.0, kFewestBeside = 2.0;
  check_variable(spec, "", kFewestKnots, joints);
  check_variable(spec, "_2", kFewestBeside, joints);
  const double values = given(spec, "knots", 0.0) * std::max(given(spec, "knots_2", 0.0), 1.0);
  if (values > kMostValues)
    throw InputError(spec.where, fmt::format("{} values", values), fmt::format("at most {}", kMostValues));
  const double period = given(spec, "period", 0.0), knots = given(spec, "knots", 0.0);
  const double apart = (given(spec, "to", 1.0) - given(spec, "from", 0.0)) / (knots - 1.0);
  if (period > 0.0 && !(std::fabs(apart * knots - period) < 1e-6 * period))
    throw InputError(spec.where, fmt::format("a period of {}", period),
                     "that of the knots, one spacing beyond the last");
  const bool reading = spec.effect == "learned_reading";
  const bool own = given(spec, "of", 0.0) == 0.0 && given(spec, "over", 0.0) == 0.0;
  if (reading && (!own || given(spec, "knots_2", 0.0) > 0.0))
    throw InputError(spec.where, "another variable", "the joint's own position: learned_reading has no other");
}

}  // namespace

void PlantModel::add_effect(const EffectSpec& spec) {
  const int type = find_effect(spec.effect);
  if (type < 0) {
    throw InputError(spec.where, "effect " + quoted(spec.effect), "one of " + names_of_table(effect_table()));
  }
  const EffectInfo& info = effect_table()[type];
  const std::optional<int> joint = robot_->find_joint(spec.place);
  const bool fits = info.where == Where::arm ? spec.place == "arm" : joint.has_value();
  if (!fits) {
    throw InputError(spec.where, "where: " + quoted(spec.place), info.where == Where::arm ? "arm" : "a joint's name");
  }
  if (joint && !suits(type, actuators_[*joint].type)) {
    const bool chambers = Effects::hooks<double>()[type].chambers != nullptr;
    throw InputError(spec.where, "effect " + quoted(spec.effect) + " at " + quoted(spec.place),
                     chambers ? "a joint whose actuator is a flow_source or hydraulic"
                              : "a joint whose actuator integrates the flow of its valve (flow_source)");
  }
  const int others = count_apart(spec);
  const std::vector<EffectParameter> parameters =
      effect_parameters(info, *robot_, info.where == Where::arm ? -1 : *joint, values_of(spec));
  check_keys(spec.parameters, parameters, spec.where, spec.effect);
  effects_.push_back({type, info.where == Where::arm ? -1 : *joint, static_cast<int>(parameters_.size()),
                      static_cast<int>(parameters.size()), spec.recordings});
  for (const EffectParameter& p : parameters) {
    const bool prismatic = p.joint >= 0 && robot_->joints()[p.joint].prismatic();
    const std::string command = p.joint >= 0 ? command_unit(p.joint) : kAnyCommand;
    const double value = checked(p, spec.parameters, spec.where, spec.effect);
    const std::string again = others > 0 ? fmt::format("#{}", others + 1) : "";
    parameters_.push_back({spec.place + "." + spec.effect + again + "." + p.key,
                           unit_at(p.info->unit, prismatic, command), value, p.info->neutral, p.info->lower,
                           p.info->upper, p.info, p.key, p.joint});
  }
  check_order(parameters, std::span(parameters_).last(parameters.size()), spec.where);
  if (info.learned) check_knots(spec, dof());
  if (Effects::hooks<double>()[type].base != nullptr) moving_robot_ = on_two_hinges(*robot_);
}

std::vector<double> PlantModel::values() const {
  std::vector<double> out;
  out.reserve(parameters_.size());
  for (const Parameter& p : parameters_) out.push_back(p.value);
  return out;
}

int PlantModel::find(const std::string& name) const {
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    if (parameters_[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

std::vector<int> PlantModel::matching(const std::string& kind_or_name) const {
  if (const int one = find(kind_or_name); one >= 0) return {one};
  std::vector<int> out;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const std::string& name = parameters_[i].name;
    const std::size_t dot = name.find('.');
    if (name.compare(dot + 1, std::string::npos, kind_or_name) == 0) out.push_back(static_cast<int>(i));
  }
  return out;
}

int PlantModel::find_effect_at(const std::string& effect, const std::string& place) const {
  for (std::size_t i = 0; i < effects_.size(); ++i) {
    const char* name = effect_table()[effects_[i].type].name;
    if (effect == name && place_name(effects_[i]) == place) return static_cast<int>(i);
  }
  return -1;
}

std::vector<double> PlantModel::values_in(const std::string& file, std::span<const double> values) const {
  std::vector<double> out(values.begin(), values.end());
  for (const Component& effect : effects_) {
    const auto& acts = effect.recordings;
    if (acts.empty() || std::find(acts.begin(), acts.end(), file) != acts.end()) continue;
    for (int k = 0; k < effect.count; ++k) {
      const std::size_t i = effect.first + k;
      out[i] = parameters_[i].neutral;
    }
  }
  return out;
}

std::vector<double> PlantModel::link_masses(std::span<const double> values) const {
  std::vector<double> masses(mass_parameter_.size(), 0.0);
  for (std::size_t i = 0; i < masses.size(); ++i) {
    masses[i] = mass_parameter_[i] < 0 ? robot_->links()[i].inertial.mass : values[mass_parameter_[i]];
  }
  return masses;
}

std::vector<Inertial> PlantModel::inertials(std::span<const double> values) const {
  const std::vector<double> masses = link_masses(values);
  std::vector<Inertial> bodies;
  for (int i = 0; i < dof(); ++i) bodies.push_back(robot_->body_inertial(i, masses));
  // In the catalogue's order, however the scenario lists them: a body is what it is before it carries anything.
  const std::vector<Hooks<double>>& table = Effects::hooks<double>();
  for (std::size_t type = 0; type < table.size(); ++type) {
    if (table[type].inertials == nullptr) continue;
    for (const Component& effect : effects_) {
      if (effect.type != static_cast<int>(type)) continue;
      table[type].inertials(values.data() + effect.first, *robot_, effect.joint, bodies);
    }
  }
  return bodies;
}

std::vector<double> PlantModel::armatures(std::span<const double> values) const {
  std::vector<double> out(dof(), 0.0);
  for (const Component& effect : effects_) {
    const Hooks<double>& hooks = Effects::hooks<double>()[effect.type];
    if (hooks.armature == nullptr) continue;
    out[effect.joint] += hooks.armature(values.data() + effect.first);
  }
  return out;
}

Eigen::Vector3d PlantModel::gravity(std::span<const double> values) const {
  Eigen::Vector3d out = gravity_;
  for (const Component& effect : effects_) {
    const Hooks<double>& hooks = Effects::hooks<double>()[effect.type];
    if (hooks.gravity != nullptr) out = hooks.gravity(values.data() + effect.first, out);
  }
  return out;
}

std::string PlantModel::place_name(const Component& component) const {
  return component.joint < 0 ? "arm" : robot_->joints()[component.joint].name;
}

namespace {

bool has_chambers(const Component& actuator) { return actuator.type >= 0 && actuator_table()[actuator.type].chambers; }

}  // namespace

std::vector<std::string> idle_effects(const Scenario& scenario) {
  const PlantModel model(scenario);
  std::set<int> searched;
  for (const IdentifySpec& spec : scenario.identify)
    for (const int index : model.matching(spec.name)) searched.insert(index);
  std::vector<std::string> out;
  for (const Component& effect : model.effects()) {
    const EffectInfo& info = effect_table()[effect.type];
    const ParameterInfo& lead = leading_parameter(info);
    std::string idle;
    bool acts = info.learned;
    for (int index = effect.first; index < effect.first + effect.count; ++index) {
      const Parameter& p = model.parameters()[index];
      const bool strength = info.as_one || p.info->scale == lead.scale;
      if (!strength || p.info->optional || p.info->structural) continue;
      acts = acts || p.value != p.neutral || searched.count(index) > 0;
      idle += fmt::format("{}{} = {:g}", idle.empty() ? "" : ", ", p.key, p.value);
    }
    // What stands before measured pressures has had its say in them.
    const bool before = scenario.pressure_driven && info.stage < Stage::effort && effect.joint >= 0 &&
                        has_chambers(model.actuators()[effect.joint]);
    if (before) idle = "measured pressures drive the joint";
    if (before || !acts)
      out.push_back(
          fmt::format("effects: {} at {} does nothing: {}", info.name, printable(model.place_name(effect), 60), idle));
  }
  return out;
}

bool has_effect_of_the_arm(const PlantModel& model) {
  return std::any_of(model.effects().begin(), model.effects().end(),
                     [](const Component& effect) { return effect.joint < 0; });
}

std::vector<int> branches(const PlantModel& model) {
  const std::vector<Joint>& joints = model.robot().joints();
  std::vector<int> out(joints.size(), 0);
  if (has_effect_of_the_arm(model)) return out;
  for (std::size_t j = 0; j < joints.size(); ++j)
    out[j] = joints[j].parent < 0 ? static_cast<int>(j) : out[joints[j].parent];
  return out;
}

}  // namespace lacuna
