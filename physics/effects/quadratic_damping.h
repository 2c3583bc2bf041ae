#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Flow through an orifice or drag in a fluid. Neutral at c = 0.
struct QuadraticDamping {
  static EffectInfo info() {
    return {"quadratic_damping",
            "Quadratic damping",
            Where::joint,
            Stage::link,
            "tau -= c |v| v",
            "error at high speed",
            "damping",
            "orifice equation; H. E. Merritt, Hydraulic Control Systems, 1967, ch. 3",
            {{"c", "N m s^2/rad^2", 0.0, 0.0, 1e9, "drag", Scale::drag, {0.1}}}};
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return T(0.0) - p[0] * abs(s.v) * s.v;
  }
};

}  // namespace lacuna
