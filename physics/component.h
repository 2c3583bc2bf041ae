// How an actuator or an effect acts on one joint: the few hooks a plant calls, each optional.
//
// A component is a struct with a static `info()` and the static member templates it needs, written over the scalar type
// T (`double` or a SIMD pack, backends/featherstone/scalar.h) and therefore branch-free: use select(), min(), max().
// `p` points at the component's parameters in the order of its info, `s.z` at its own states.
#pragma once

#include <cmath>
#include <vector>

#include "backends/featherstone/scalar.h"
#include "scenarios/robot.h"

namespace lacuna {

/// What a component may see of its joint at one instant.
template <class T>
struct JointView {
  T t = T(0.0);                 ///< s, from the start of the recording
  T q = T(0.0), v = T(0.0);     ///< rad, rad/s (m, m/s)
  T u = T(0.0);                 ///< V, command as it reaches this component
  const T* actuator = nullptr;  ///< parameters of the joint's actuator
  const T* z = nullptr;         ///< the component's own states
};

/// Search coordinate of a parameter whose neutral value lies at infinity: optimisers see its inverse.
enum class Coordinate { linear, inverse };

/// What a typical size of a parameter is measured in; the experiment supplies the value (ga/search_space.h).
enum class Scale { ratio, command, effort, time, mass, velocity, position };

struct ParameterInfo {
  const char* name;
  const char* unit;
  double neutral;       ///< at this value the component does nothing (effects) or the default (actuators)
  double lower, upper;  ///< physical range
  const char* meaning;
  Scale scale = Scale::ratio;
  std::vector<double> starts = {};  ///< sizes to start a search from, in units of `scale`
  Coordinate coordinate = Coordinate::linear;
  bool optional = false;  ///< a refinement of the effect's shape: tried free, and fixed at its neutral value
};

/// Hooks of one component for one scalar type; null where the component does not act.
template <class T>
struct Hooks {
  T (*command)(const T* p, const JointView<T>& s) = nullptr;  ///< V: s.u changed
  T (*effort)(const T* p, const JointView<T>& s) = nullptr;   ///< N m or N: smooth effort on the joint
  /// N m or N, >= 0: dry friction's magnitude at sliding speed `speed` >= 0; at speed 0 the break-away effort.
  T (*dry_friction)(const T* p, const T& speed, const JointView<T>& s) = nullptr;
  T (*delay)(const T* p) = nullptr;                        ///< s, of the command
  T (*rate)(const T* p, const JointView<T>& s) = nullptr;  ///< derivative of the component's one state
  /// State at the start: joint at q, v under command s.u, `holding` the effort that keeps it in place.
  T (*initial)(const T* p, const JointView<T>& s, const T& holding) = nullptr;
  /// Mass properties changed, per body (one lane at a time: done once for a simulation, not once a step).
  void (*inertials)(const double* p, const Robot& robot, int joint, std::vector<Inertial>& bodies) = nullptr;

  int states() const { return rate != nullptr ? 1 : 0; }
};

/// Fills the hooks that component C defines.
template <class C, class T>
Hooks<T> hooks_of() {
  Hooks<T> h;
  if constexpr (requires { &C::template command<T>; }) h.command = &C::template command<T>;
  if constexpr (requires { &C::template effort<T>; }) h.effort = &C::template effort<T>;
  if constexpr (requires { &C::template dry_friction<T>; }) h.dry_friction = &C::template dry_friction<T>;
  if constexpr (requires { &C::template delay<T>; }) h.delay = &C::template delay<T>;
  if constexpr (requires { &C::template rate<T>; }) h.rate = &C::template rate<T>;
  if constexpr (requires { &C::template initial<T>; }) h.initial = &C::template initial<T>;
  if constexpr (requires { &C::inertials; }) h.inertials = &C::inertials;
  return h;
}

/// A table of components; `table.h` of actuators and of effects each name one.
template <class... C>
struct ComponentList {
  /// `info()` of each, in order.
  template <class Info>
  static std::vector<Info> infos() {
    return {C::info()...};
  }
  template <class T>
  static const std::vector<Hooks<T>>& hooks() {
    static const std::vector<Hooks<T>> table{hooks_of<C, T>()...};
    return table;
  }
};

}  // namespace lacuna
