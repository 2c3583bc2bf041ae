// The constant model of a plant: robot, actuators, effects, and one flat list of named parameters.
//
// Everything that can differ between two simulations of the same plant is a number in `values`: link masses, actuator
// and effect parameters. A population is a list of such vectors. Immutable after construction; shared by all threads.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "physics/catalogue.h"
#include "scenarios/scenario.h"

namespace lacuna {

/// One number of the plant.
struct Parameter {
  std::string name;  ///< "joint_2.gain", "link_3.mass", "joint_2.coulomb_friction.Fc", "arm.payload.m"
  std::string unit;
  double value;                         ///< from the scenario
  double neutral;                       ///< where the effect vanishes (effects)
  double lower, upper;                  ///< physical range
  const ParameterInfo* info = nullptr;  ///< null for link masses
  std::string key = {};                 ///< the last part of its name, as a scenario writes it
  int joint = -1;                       ///< whose sizes it is measured by; -1: the arm
};

/// What an effect at a joint (-1: the arm) is given by on this robot: its parameters, those of every joint one by one.
struct EffectParameter {
  std::string key;
  const ParameterInfo* info;
  int joint;
};
std::vector<EffectParameter> effect_parameters(const EffectInfo& info, const Robot& robot, int joint, int knots = 0);

/// An actuator or an effect at its place.
struct Component {
  int type = -1;   ///< index in actuator_table() or effect_table()
  int joint = -1;  ///< -1: the arm
  int first = 0;   ///< index of its first parameter
  int count = 0;
  std::vector<std::string> recordings;  ///< files in which an effect acts; empty: all
};

class PlantModel {
 public:
  /// Throws InputError naming the scenario's entry: unknown model or effect, unknown, missing or out-of-range
  /// parameter, an effect twice at one place.
  explicit PlantModel(const Scenario& scenario);

  /// The same plant with more effects, each at its neutral value unless `spec.parameters` says otherwise.
  PlantModel with_effects(const std::vector<EffectSpec>& specs) const;

  const Robot& robot() const { return *robot_; }
  const std::shared_ptr<const Robot>& robot_ptr() const { return robot_; }
  const Eigen::Vector3d& gravity() const { return gravity_; }
  int dof() const { return robot_->dof(); }
  /// What the engines simulate: the robot, or where an effect sets it on springs, with two joints under its base that
  /// turn it about x and y; they come first.
  const std::shared_ptr<const Robot>& moving_robot() const { return moving_robot_; }
  /// Of joint j's command (units.h).
  const std::string& command_unit(int j) const { return command_units_[j]; }
  bool on_springs() const { return moving_robot_ != robot_; }

  const std::vector<Parameter>& parameters() const { return parameters_; }
  std::vector<double> values() const;
  /// Index of a parameter, or -1.
  int find(const std::string& name) const;
  /// Names of all parameters of a kind ("gain", "mass") or the one of that full name; empty: none.
  std::vector<int> matching(const std::string& kind_or_name) const;

  /// One actuator per joint; type -1: a passive joint.
  const std::vector<Component>& actuators() const { return actuators_; }
  const std::vector<Component>& effects() const { return effects_; }
  int find_effect_at(const std::string& effect, const std::string& place) const;

  /// `values` with every effect that does not act in recording `file` at its neutral value.
  std::vector<double> values_in(const std::string& file, std::span<const double> values) const;

  /// Mass properties of all bodies, URDF body frames: link masses and effects put in.
  std::vector<Inertial> inertials(std::span<const double> values) const;
  /// kg m^2 (kg) added at each joint.
  std::vector<double> armatures(std::span<const double> values) const;
  /// m/s^2, base frame, effects put in.
  Eigen::Vector3d gravity(std::span<const double> values) const;
  /// kg, one per link, from `values`.
  std::vector<double> link_masses(std::span<const double> values) const;

  /// "joint_2" or "arm".
  std::string place_name(const Component& component) const;

 private:
  void add_actuator(const ActuatorSpec& spec);
  void add_effect(const EffectSpec& spec);
  int count_apart(const EffectSpec& spec) const;

  std::shared_ptr<const Robot> robot_, moving_robot_;
  Eigen::Vector3d gravity_;
  std::vector<std::string> command_units_;
  std::vector<Parameter> parameters_;
  std::vector<int> mass_parameter_;  ///< per link: its parameter, or -1
  std::vector<Component> actuators_, effects_;
};

/// In words, of each effect of a scenario that does nothing as it is given, and that `identify` leaves as it is.
std::vector<std::string> idle_effects(const Scenario& scenario);

/// Whether an effect acts on the whole arm: then every joint may move every other.
bool has_effect_of_the_arm(const PlantModel& model);

/// [joint]: the branch of the tree on which it sits, by the branch's first joint, where what moves on one branch cannot
/// move another: the base stands still and no effect acts on the whole arm. Else all of them 0.
std::vector<int> branches(const PlantModel& model);

}  // namespace lacuna
