#include "ga/search_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "scenarios/error.h"

namespace lacuna {
namespace {

bool is_mass(const Parameter& parameter) { return parameter.info == nullptr; }

Axis axis_for(const PlantModel& model, const IdentifySpec& spec, int index) {
  const Parameter& p = model.parameters()[static_cast<std::size_t>(index)];
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
  if (p.info != nullptr && p.info->coordinate == Coordinate::inverse) {
    axis = {index, 1.0 / axis.upper, 1.0 / axis.lower, 1.0 / p.value, Coordinate::inverse};
  } else if (p.info != nullptr && p.info->coordinate == Coordinate::logarithm && axis.lower > 0.0) {
    axis = {index, std::log(axis.lower), std::log(axis.upper), std::log(p.value), Coordinate::logarithm};
  }
  return axis;
}

}  // namespace

SearchSpace::SearchSpace(const PlantModel& model, const Scenario& scenario) : base_(model.values()) {
  for (const IdentifySpec& spec : scenario.identify) {
    const std::vector<int> found = model.matching(spec.name);
    if (found.empty()) {
      throw InputError(
          spec.where, quoted(spec.name),
          "a parameter's kind (gain, mass, ...) or full name (joint.gain, link.mass, joint.effect.parameter)");
    }
    for (const int index : found) {
      const Axis axis = axis_for(model, spec, index);
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
  for (std::size_t i = 0; i < model.parameters().size(); ++i) {
    if (is_mass(model.parameters()[i])) known += model.parameters()[i].value;
  }
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (!is_mass(model.parameters()[static_cast<std::size_t>(axes_[a].parameter)])) continue;
    known -= axes_[a].start;
    lowest += axes_[a].lower;
    highest += axes_[a].upper;
    if (heaviest == axes_.size() || axes_[a].start > axes_[heaviest].start) heaviest = a;
  }
  if (heaviest == axes_.size()) return;  // no mass is searched: the total is what the robot says
  free_mass_ = *scenario.total_mass - known;
  if (free_mass_ < lowest || free_mass_ > highest) {
    throw InputError(scenario.file.string() + ": total_mass", fmt::format("{} kg", *scenario.total_mass),
                     fmt::format("{} to {} kg, what the bounds of the masses allow", known + lowest, known + highest));
  }
  dependent_ = axes_[heaviest].parameter;
  dependent_lower_ = axes_[heaviest].lower;
  dependent_upper_ = axes_[heaviest].upper;
  axes_.erase(axes_.begin() + static_cast<std::ptrdiff_t>(heaviest));
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (is_mass(model.parameters()[static_cast<std::size_t>(axes_[a].parameter)])) mass_axes_.push_back(a);
  }
}

void SearchSpace::add(const PlantModel& model, const Axis& axis) {
  const Parameter& p = model.parameters()[static_cast<std::size_t>(axis.parameter)];
  Axis cut = axis;
  const double a = to_search(axis.coordinate, p.lower), b = to_search(axis.coordinate, p.upper);
  cut.lower = std::max(cut.lower, std::min(a, b));
  cut.upper = std::min(cut.upper, std::max(a, b));
  cut.start = std::clamp(cut.start, cut.lower, cut.upper);
  axes_.push_back(cut);
  base_ = [&] {
    std::vector<double> values = model.values();
    std::copy(base_.begin(), base_.end(), values.begin());
    return values;
  }();
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
    box.names.push_back(model.parameters()[static_cast<std::size_t>(axis.parameter)].name);
  }
  return box;
}

std::vector<double> SearchSpace::start() const {
  std::vector<double> point;
  for (const Axis& axis : axes_) point.push_back(axis.start);
  return point;
}

std::vector<double> SearchSpace::expand(std::span<const double> point) const {
  std::vector<double> values = base_;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    values[static_cast<std::size_t>(axes_[a].parameter)] = from_search(axes_[a].coordinate, point[a]);
  }
  if (dependent_ < 0) return values;
  double others = 0.0;
  for (const std::size_t a : mass_axes_) others += point[a];
  const double rest = std::clamp(free_mass_ - others, dependent_lower_, dependent_upper_);
  values[static_cast<std::size_t>(dependent_)] = rest;
  if (rest != free_mass_ - others) {
    const double factor = (free_mass_ - rest) / others;
    for (const std::size_t a : mass_axes_) values[static_cast<std::size_t>(axes_[a].parameter)] = factor * point[a];
  }
  return values;
}

std::vector<double> SearchSpace::contract(std::span<const double> values) const {
  std::vector<double> point;
  for (const Axis& axis : axes_) {
    const double x = to_search(axis.coordinate, values[static_cast<std::size_t>(axis.parameter)]);
    point.push_back(std::clamp(x, axis.lower, axis.upper));
  }
  return point;
}

namespace {

/// m: the longest way from the base to a joint along the links, and on to the tool.
double stretched_length(const Robot& robot) {
  std::vector<double> way;
  double longest = 0.0;
  for (const Joint& joint : robot.joints()) {
    const double before = joint.parent < 0 ? 0.0 : way[static_cast<std::size_t>(joint.parent)];
    way.push_back(before + joint.origin.translation().norm());
    longest = std::max(longest, way.back());
  }
  const double tool = robot.tool().body < 0 ? 0.0 : robot.tool().point.norm();
  return longest + tool;
}

/// kg m^2 (kg for a slide): what moves with joint j, all joints at zero, about its axis.
double inertia_beyond(const Robot& robot, int j) {
  const Joint& joint = robot.joints()[static_cast<std::size_t>(j)];
  std::vector<std::optional<Eigen::Isometry3d>> pose(robot.joints().size());  // of bodies beyond, in the joint's frame
  pose[static_cast<std::size_t>(j)] = Eigen::Isometry3d::Identity();
  double sum = 0.0;
  for (int i = j; i < robot.dof(); ++i) {
    const Joint& own = robot.joints()[static_cast<std::size_t>(i)];
    auto& at = pose[static_cast<std::size_t>(i)];
    if (i > j && own.parent >= 0 && pose[static_cast<std::size_t>(own.parent)])
      at = *pose[static_cast<std::size_t>(own.parent)] * own.origin;
    if (!at) continue;
    const Inertial body = robot.body_inertial(i);
    const Eigen::Vector3d lever = joint.axis.cross(*at * body.com);
    const Eigen::Vector3d axis = at->linear().transpose() * joint.axis;
    sum += joint.prismatic() ? body.mass : body.mass * lever.squaredNorm() + axis.dot(body.inertia * axis);
  }
  return sum;
}

}  // namespace

double typical_size(Scale scale, const PlantModel& model, const Experiment& experiment, int joint,
                    std::span<const double> values) {
  auto positive = [](double x) { return x > 0.0 && std::isfinite(x) ? x : 1.0; };
  // Of the arm: commands, efforts and inertias of all joints together; motions as one vector.
  double command = 0.0, effort = 0.0, position = 0.0, velocity = 0.0, inertia = 0.0;
  for (int i = 0; i < model.dof(); ++i) {
    if (joint >= 0 && i != joint) continue;
    const std::size_t j = static_cast<std::size_t>(i);
    const Component& actuator = model.actuators()[j];
    const double gain = actuator.type < 0 ? 1.0 : std::fabs(values[static_cast<std::size_t>(actuator.first)]);
    command += experiment.command_rms[j];
    effort += experiment.effort_rms[j] > 0.0 ? experiment.effort_rms[j] : gain * experiment.command_rms[j];
    position = std::hypot(position, experiment.position_rms[j]);
    velocity = std::hypot(velocity, experiment.speed_rms[j]);
    if (scale == Scale::inertia) inertia += inertia_beyond(model.robot(), i);
  }
  effort = positive(effort), position = positive(position), velocity = positive(velocity);
  switch (scale) {
    case Scale::command: return positive(command);
    case Scale::effort: return effort;
    case Scale::velocity: return velocity;
    case Scale::position: return position;
    case Scale::reach: return positive(experiment.position_reach[static_cast<std::size_t>(std::max(joint, 0))]);
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

double typical_origin(Scale scale, const Experiment& experiment, int joint) {
  return scale == Scale::reach && joint >= 0 ? experiment.position_middle[static_cast<std::size_t>(joint)] : 0.0;
}

}  // namespace lacuna
