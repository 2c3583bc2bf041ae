#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// One-sided contact. k > 0: an upper stop, active beyond q_lim; k < 0: a lower one, active below it. Neutral at k = 0.
struct EndStop {
  static EffectInfo info() {
    return {"end_stop",
            "End stop",
            Where::joint,
            Stage::link,
            "k > 0, beyond q_lim: tau -= max(k (q - q_lim + T v), 0); k < 0: the same on the other side",
            "motion clipped at one angle",
            "stiffness_hardening",
            "linear penalty contact (Kelvin and Voigt), no adhesion",
            {{"q_lim", "rad", 0.0, -1e3, 1e3, "where the contact begins", Scale::reach, {0.7, -0.7}},
             stiffness(),
             {"T",
              "s",
              0.0,
              0.0,
              0.05,
              "damping of the contact over its stiffness",
              Scale::time,
              {0.002},
              Coordinate::linear,
              true}}};
  }
  static ParameterInfo stiffness() {
    ParameterInfo k{
        "k", "N m/rad", 0.0, -1e9, 1e9, "contact stiffness; negative: a lower stop", Scale::stiffness, {1.0, -1.0}};
    k.least = 10.0;  // the drive's usual effort presses it in by a tenth of the usual motion at most
    return k;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    const T side = select(p[1] > T(0.0), T(1.0), T(-1.0));
    const T beyond = side * (s.q - p[0]);
    const T push = abs(p[1]) * max(beyond + p[2] * side * s.v, T(0.0));
    return select(beyond > T(0.0), T(0.0) - side * push, T(0.0));
  }
};

}  // namespace lacuna
