#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// The base stands on springs and tilts about its x and y under the arm's weight and motion (physics/foundation.h).
/// Where motions are measured and efforts predicted it does nothing: nobody measured the base. Neutral at k = infinity.
struct BaseCompliance {
  static EffectInfo info() {
    return {
        "base_compliance",
        "Base compliance",
        Where::arm,
        Stage::link,
        "moment on the base = k tilt + c tilt', about x and y",
        "all joints ring when one starts",
        "joint_compliance, base_tilt",
        "rigid bodies on a torsion spring, e.g. S. Dubowsky, E. Papadopoulos, IEEE Trans. Robotics Autom. 9 (1993)",
        {{"k",
          "N m/rad",
          HUGE_VAL,
          1e-6,
          HUGE_VAL,
          "stiffness of the springs under the base",
          Scale::stiffness,
          {100.0, 10.0},
          Coordinate::inverse},
         {"I",
          "kg m^2",
          0.0,
          0.0,
          1e9,
          "inertia of what tilts with the base",
          Scale::inertia,
          {0.3},
          Coordinate::linear,
          true},
         {"c", "N m s/rad", 0.0, 0.0, 1e9, "damping of the springs", Scale::damping, {0.5}, Coordinate::linear, true}}};
  }
  template <class T>
  static BaseSpring<T> base(const T* p) {
    return {p[0], p[1], p[2]};
  }
};

}  // namespace lacuna
