#pragma once

#include "physics/effects/transmission.h"

namespace lacuna {

/// Free travel between actuator and link. In contact the actuator's side pulls the link through a damped spring; in
/// flight the link gets nothing, and that side crosses the gap against the actuator's own damper and spring. Neutral at
/// gap = 0.
struct Backlash : SideOfItsOwn<Backlash> {
  static EffectInfo info() {
    EffectInfo info{
        "backlash",
        "Backlash",
        Where::joint,
        Stage::transmission,
        "no effort while the actuator crosses from -gap to +gap; beyond, tau = k (theta - q -+ gap) + c (theta' - v)",
        "lost motion after each reversal of the effort",
        "sensor_backlash, valve_hysteresis",
        "M. Nordin and P.-O. Gutman, Automatica 38 (2002): dead zone between two sides",
        {{"gap", "rad", 0.0, 0.0, 10.0, "free travel to either side", Scale::position, {0.01, 0.05}},
         {"k",
          "N m/rad",
          HUGE_VAL,
          1e-6,
          HUGE_VAL,
          "stiffness of the contact",
          Scale::stiffness,
          {100.0, 20.0},
          Coordinate::logarithm},
         side_inertia(),
         spring_damping()}};
    info.contains = "armature";
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return select(acts(p), side(p, s).effort(s.z[0] - s.q, s.z[1] - s.v) - s.drive, T(0.0));
  }

  template <class T>
  static T lead(const T* p, const T& effort) {
    return sign(effort) * p[0] + effort / p[1];
  }

  template <class T>
  static Mask<T> acts(const T* p) {
    return p[0] > T(0.0);
  }
  template <class T>
  static Transmission<T> side(const T* p, const JointView<T>& s) {
    return Transmission<T>::of(s, p[1], p[3], p[0], p[2]);
  }
};

}  // namespace lacuna
