#include "ga/search_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "physics/actuators/table.h"
#include "scenarios/error.h"

namespace lacuna {
namespace {

bool is_mass(const Parameter& parameter) { return parameter.info == nullptr; }

/// Bounds are read as this many standard deviations of the prior from end to end.
constexpr double kDeviationsInRange = 4.0;

double prior_of(double range) { return range > 0.0 && std::isfinite(range) ? range / kDeviationsInRange : HUGE_VAL; }

Axis axis_for(const PlantModel& model, const IdentifySpec& spec, int index, Coordinates coordinates) {
  const Parameter& p = model.parameters()[index];
  if (spec.relative && p.value == 0.0) {
    throw InputError(spec.where, p.name + " = 0 with relative bounds",
                     "absolute bounds [min, max] for a start value of 0");
  }
  double lower = spec.relative ? spec.lower * p.value : spec.lower;
  double upper = spec.relative ? spec.upper * p.value : spec.upper;
  if (lower > upper) std::swap(lower, upper);
  if (p.value < lower || p.value > upper) {
    throw InputError(spec.where, fmt::format("{} = {} outside its bounds", p.name, p.value),
                     fmt::format("a start value from {} to {} {}", lower, upper, p.unit));
  }
  Axis axis{index, std::max(lower, p.lower), std::min(upper, p.upper), p.value, Coordinate::linear};
  const bool ratios = coordinates == Coordinates::ratios;
  if (p.info != nullptr && p.info->coordinate == Coordinate::inverse) {
    axis = {index, 1.0 / axis.upper, 1.0 / axis.lower, 1.0 / p.value, Coordinate::inverse};
  } else if (p.info != nullptr && p.info->coordinate == Coordinate::logarithm && axis.lower > 0.0) {
    axis = {index, std::log(axis.lower), std::log(axis.upper), std::log(p.value), Coordinate::logarithm};
  } else if (ratios && axis.lower * axis.upper > 0.0) {
    const auto [low, high] = std::minmax({std::log(axis.lower / p.value), std::log(axis.upper / p.value)});
    axis = {index, low, high, 0.0, Coordinate::logarithm};
    axis.unit = p.value;
  }
  if (ratios) axis.prior = prior_of(axis.upper - axis.lower), axis.center = axis.start;
  return axis;
}

/// `total` in shares proportional to `weights`, each within its bounds: one factor of all weights, at which the sum of
/// what the bounds let through is the total. The sum grows with it, and is linear between the factors at which a
/// share reaches a bound.
std::vector<double> share_out(double total, const std::vector<double>& weights, const std::vector<SharedMass>& bounds) {
  const auto shares = [&](double factor) {
    std::vector<double> out;
    for (std::size_t i = 0; i < weights.size(); ++i)
      out.push_back(std::clamp(factor * weights[i], bounds[i].lower, bounds[i].upper));
    return out;
  };
  const auto sum = [](const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); };
  const double plain = total / sum(weights);
  std::vector<double> out = shares(plain);
  if (std::fabs(sum(out) - total) <= 1e-15 * total) return out;
  std::vector<double> kinks{0.0};
  for (std::size_t i = 0; i < weights.size(); ++i) {
    kinks.push_back(bounds[i].lower / weights[i]);
    kinks.push_back(bounds[i].upper / weights[i]);
  }
  std::sort(kinks.begin(), kinks.end());
  const auto above =
      std::find_if(kinks.begin() + 1, kinks.end() - 1, [&](double f) { return sum(shares(f)) >= total; });
  const double low = *(above - 1), high = *above, at_low = sum(shares(low)), at_high = sum(shares(high));
  const double part = at_high > at_low ? std::clamp((total - at_low) / (at_high - at_low), 0.0, 1.0) : 1.0;
  return shares(low + part * (high - low));
}

}  // namespace

SearchSpace::SearchSpace(const PlantModel& model, const Scenario& scenario, Coordinates coordinates)
    : base_(model.values()), coordinates_(coordinates) {
  note_orders(model);
  for (const IdentifySpec& spec : scenario.identify) {
    const std::vector<int> found = model.matching(spec.name);
    if (found.empty()) {
      throw InputError(
          spec.where, quoted(spec.name),
          "a parameter's kind (gain, mass, ...) or full name (joint.gain, link.mass, joint.effect.parameter)");
    }
    for (const int index : found) {
      const ParameterInfo* info = model.parameters()[index].info;
      if (info != nullptr && info->structural)
        throw InputError(spec.where, quoted(spec.name),
                         "a number that can be searched, not one that says what a law is made of");
      if (info != nullptr && info->fills && scenario.pressure_driven)
        throw InputError(spec.where, quoted(model.parameters()[index].name),
                         "an area or a length of the linkage: measured pressures drive this joint, and what fills its "
                         "chambers does nothing");
      const Axis axis = axis_for(model, spec, index, coordinates);
      const auto same = std::find_if(axes_.begin(), axes_.end(), [&](const Axis& a) { return a.parameter == index; });
      if (same == axes_.end()) {
        axes_.push_back(axis);
      } else if (found.size() == 1) {
        *same = axis;  // a full name refines its kind
      }
    }
  }
  if (scenario.total_mass) constrain_total_mass(model, scenario);
}

void SearchSpace::constrain_total_mass(const PlantModel& model, const Scenario& scenario) {
  double known = 0.0, lowest = 0.0, highest = 0.0;
  std::size_t heaviest = axes_.size();
  std::vector<SharedMass> masses;
  for (std::size_t i = 0; i < model.parameters().size(); ++i) {
    if (is_mass(model.parameters()[i])) known += model.parameters()[i].value;
  }
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (!is_mass(model.parameters()[axes_[a].parameter])) continue;
    const Axis& axis = axes_[a];
    masses.push_back(
        {axis.parameter, static_cast<int>(a), axis.value(axis.start), axis.value(axis.lower), axis.value(axis.upper)});
    known -= masses.back().start;
    lowest += masses.back().lower;
    highest += masses.back().upper;
    if (heaviest == axes_.size() || masses.back().start > axes_[heaviest].value(axes_[heaviest].start)) heaviest = a;
  }
  if (heaviest == axes_.size()) return;  // no mass is searched: the total is what the robot says
  free_mass_ = *scenario.total_mass - known;
  if (free_mass_ < lowest || free_mass_ > highest) {
    throw InputError(scenario.file.string() + ": total_mass", fmt::format("{} kg", *scenario.total_mass),
                     fmt::format("{} to {} kg, what the bounds of the masses allow", known + lowest, known + highest));
  }
  dependent_ = axes_[heaviest].parameter;
  const auto positive = [](const SharedMass& m) { return m.lower > 0.0; };
  if (coordinates_ == Coordinates::ratios && std::all_of(masses.begin(), masses.end(), positive)) {
    return share_total_mass(std::move(masses), heaviest);
  }
  dependent_lower_ = axes_[heaviest].lower;
  dependent_upper_ = axes_[heaviest].upper;
  axes_.erase(axes_.begin() + static_cast<std::ptrdiff_t>(heaviest));
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (is_mass(model.parameters()[axes_[a].parameter])) mass_axes_.push_back(a);
  }
}

void SearchSpace::share_total_mass(std::vector<SharedMass> masses, std::size_t heaviest) {
  const Axis reference = axes_[heaviest];
  for (SharedMass& mass : masses) {
    const std::size_t a = mass.axis;
    mass.axis = a == heaviest ? -1 : mass.axis - (a > heaviest ? 1 : 0);
    if (a == heaviest) continue;
    // Of the ratio of two masses: both their ranges.
    Axis& axis = axes_[a];
    axis.prior = std::hypot(axis.prior, reference.prior);
    axis.lower -= reference.upper;
    axis.upper -= reference.lower;
  }
  axes_.erase(axes_.begin() + static_cast<std::ptrdiff_t>(heaviest));
  shared_ = std::move(masses);
}

void SearchSpace::add(const PlantModel& model, const Axis& axis) {
  const Parameter& p = model.parameters()[axis.parameter];
  Axis cut = axis;
  const double a = to_search(axis.coordinate, p.lower), b = to_search(axis.coordinate, p.upper);
  cut.lower = std::max(cut.lower, std::min(a, b));
  cut.upper = std::min(cut.upper, std::max(a, b));
  cut.start = std::clamp(cut.start, cut.lower, cut.upper);
  axes_.push_back(cut);
  hold(model);
  note_orders(model);
}

void SearchSpace::hold(const PlantModel& model) {
  std::vector<double> values = model.values();
  std::copy(base_.begin(), base_.end(), values.begin());
  base_ = std::move(values);
}

void SearchSpace::replace(std::vector<Axis> axes) {
  bool same = axes.size() == axes_.size();
  for (std::size_t a = 0; same && a < axes.size(); ++a) {
    same = axes[a].parameter == axes_[a].parameter && axes[a].coordinate == axes_[a].coordinate;
  }
  if (!same) throw std::invalid_argument("other axes than those of the search space");
  axes_ = std::move(axes);
}

Box SearchSpace::box(const PlantModel& model) const {
  Box box;
  for (const Axis& axis : axes_) {
    box.lower.push_back(axis.lower);
    box.upper.push_back(axis.upper);
    box.names.push_back(model.parameters()[axis.parameter].name);
  }
  return box;
}

std::vector<double> SearchSpace::start() const {
  std::vector<double> point;
  for (const Axis& axis : axes_) point.push_back(axis.start);
  return point;
}

std::vector<double> SearchSpace::expand(std::span<const double> point) const {
  if (point.size() < axes_.size())
    throw std::logic_error(fmt::format("SearchSpace::expand: {} coordinates for {} axes", point.size(), axes_.size()));
  std::vector<double> values = base_;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    values[axes_[a].parameter] = axes_[a].value(point[a]);
  }
  for (const auto& [higher, lower] : orders_) values[higher] = std::max(values[higher], values[lower]);
  if (!shared_.empty()) expand_masses(point, values);
  if (dependent_ < 0 || !shared_.empty()) return values;
  double others = 0.0;
  for (const std::size_t a : mass_axes_) others += point[a];
  const double rest = std::clamp(free_mass_ - others, dependent_lower_, dependent_upper_);
  values[dependent_] = rest;
  if (rest != free_mass_ - others) {
    const double factor = (free_mass_ - rest) / others;
    for (const std::size_t a : mass_axes_) values[axes_[a].parameter] = factor * point[a];
  }
  return values;
}

void SearchSpace::note_orders(const PlantModel& model) {
  orders_.clear();
  const auto& all = model.parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].info == nullptr || all[i].info->at_least == nullptr) continue;
    const std::string other = all[i].name.substr(0, all[i].name.size() - all[i].key.size()) + all[i].info->at_least;
    if (const int j = model.find(other); j >= 0) orders_.emplace_back(i, static_cast<std::size_t>(j));
  }
}

void SearchSpace::expand_masses(std::span<const double> point, std::vector<double>& values) const {
  std::vector<double> weights;
  for (const SharedMass& mass : shared_)
    weights.push_back(mass.axis < 0 ? mass.start : mass.start * std::exp(point[mass.axis]));
  const std::vector<double> kilograms = share_out(free_mass_, weights, shared_);
  for (std::size_t i = 0; i < shared_.size(); ++i) values[shared_[i].parameter] = kilograms[i];
}

std::vector<double> SearchSpace::contract(std::span<const double> values) const {
  std::vector<double> point;
  for (const Axis& axis : axes_) point.push_back(axis.at(values[axis.parameter]));
  double reference = 0.0;
  for (const SharedMass& mass : shared_)
    if (mass.axis < 0) reference = std::log(values[mass.parameter] / mass.start);
  for (const SharedMass& mass : shared_)
    if (mass.axis >= 0) point[mass.axis] -= reference;
  for (std::size_t a = 0; a < axes_.size(); ++a) point[a] = std::clamp(point[a], axes_[a].lower, axes_[a].upper);
  return point;
}

namespace {

/// m: the longest way from the base to a joint along the links, and on to the tool.
double stretched_length(const Robot& robot) {
  std::vector<double> way;
  double longest = 0.0;
  for (const Joint& joint : robot.joints()) {
    const double before = joint.parent < 0 ? 0.0 : way[joint.parent];
    way.push_back(before + joint.origin.translation().norm());
    longest = std::max(longest, way.back());
  }
  const double tool = robot.tool().body < 0 ? 0.0 : robot.tool().point.norm();
  return longest + tool;
}

/// kg m^2 (kg for a slide): what moves with joint j, all joints at zero, about its axis.
double inertia_beyond(const Robot& robot, int j) {
  const Joint& joint = robot.joints()[j];
  std::vector<std::optional<Eigen::Isometry3d>> pose(robot.joints().size());  // of bodies beyond, in the joint's frame
  pose[j] = Eigen::Isometry3d::Identity();
  double sum = 0.0;
  for (int i = j; i < robot.dof(); ++i) {
    const Joint& own = robot.joints()[i];
    auto& at = pose[i];
    if (i > j && own.parent >= 0 && pose[own.parent]) at = *pose[own.parent] * own.origin;
    if (!at) continue;
    const Inertial body = robot.body_inertial(i);
    const Eigen::Vector3d lever = joint.axis.cross(*at * body.com);
    const Eigen::Vector3d axis = at->linear().transpose() * joint.axis;
    sum += joint.prismatic() ? body.mass : body.mass * lever.squaredNorm() + axis.dot(body.inertia * axis);
  }
  return sum;
}

}  // namespace

namespace {

/// N m (N), what the joint's actuator gives under its usual command. A drive that integrates its flow has no effort of
/// its own: what its oil spring and damper bear where the usual flow is blocked at once, which is the speed times the
/// damping and sqrt(stiffness inertia), the spring's impedance.
double usual_effort(const PlantModel& model, const Experiment& experiment, int joint, std::span<const double> values) {
  const Component& actuator = model.actuators()[joint];
  if (actuator.type < 0) return experiment.command_rms[joint];
  const Hooks<double>& hooks = Actuators::hooks<double>()[actuator.type];
  const double* p = &values[actuator.first];
  if (hooks.strength != nullptr) return std::fabs(hooks.strength(p)) * experiment.command_rms[joint];
  const ActuatorRoles& roles = actuator_table()[actuator.type].roles;
  const auto role = [&](int at, double otherwise) { return at < 0 ? otherwise : std::fabs(p[at]); };
  const double given = role(roles.gain, 1.0) * experiment.command_rms[joint];
  if (hooks.flow == nullptr) return given;
  const double spring = role(roles.stiffness, 0.0) * inertia_beyond(model.robot(), joint);
  return given * (role(roles.damping, 0.0) + std::sqrt(spring));
}

}  // namespace

double typical_size(Scale scale, const PlantModel& model, const Experiment& experiment, int joint,
                    std::span<const double> values) {
  auto positive = [](double x) { return x > 0.0 && std::isfinite(x) ? x : 1.0; };
  // Of the arm: commands, efforts and inertias of all joints together; motions as one vector.
  double command = 0.0, effort = 0.0, position = 0.0, velocity = 0.0, inertia = 0.0;
  for (int i = 0; i < model.dof(); ++i) {
    if (joint >= 0 && i != joint) continue;
    command += experiment.command_rms[i];
    effort += experiment.effort_rms[i] > 0.0 ? experiment.effort_rms[i] : usual_effort(model, experiment, i, values);
    position = std::hypot(position, experiment.position_rms[i]);
    velocity = std::hypot(velocity, experiment.speed_rms[i]);
    if (scale == Scale::inertia) inertia += inertia_beyond(model.robot(), i);
  }
  const double reach = positive(experiment.position_reach[static_cast<std::size_t>(std::max(joint, 0))]);
  effort = positive(effort), position = positive(position), velocity = positive(velocity);
  switch (scale) {
    case Scale::command: return positive(command);
    case Scale::effort: return effort;
    case Scale::velocity: return velocity;
    case Scale::position: return position;
    case Scale::reach: return reach;
    case Scale::travel: return 2.0 * reach;
    case Scale::wave: return std::numbers::pi / reach;
    case Scale::span: return positive(experiment.span);
    case Scale::length: return positive(0.1 * stretched_length(model.robot()));
    case Scale::mass: return model.robot().moving_mass();
    case Scale::stiffness: return effort / position;
    case Scale::damping: return effort / velocity;
    case Scale::drag: return effort / (velocity * velocity);
    case Scale::hardening: return effort / (position * position * position);
    case Scale::inertia: return positive(inertia);
    default: return 1.0;
  }
}

double driven_inertia(const PlantModel& model, const Experiment& experiment, int joint) {
  const double effort = typical_size(Scale::effort, model, experiment, joint, model.values());
  const double speed = typical_size(Scale::velocity, model, experiment, joint, model.values());
  return effort * typical_size(Scale::position, model, experiment, joint, model.values()) / (speed * speed);
}

double typical_origin(Scale scale, const Experiment& experiment, int joint) {
  return scale == Scale::reach && joint >= 0 ? experiment.position_middle[joint] : 0.0;
}

}  // namespace lacuna
