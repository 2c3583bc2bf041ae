#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// One-sided contact. k > 0: an upper stop, active beyond q_lim; k < 0: a lower one, active below it. Neutral at k = 0.
struct EndStop {
  static EffectInfo info() {
    return {
        "end_stop",
        "End stop",
        Where::joint,
        "k > 0: tau -= k max(q - q_lim, 0); k < 0: tau += |k| max(q_lim - q, 0)",
        "motion clipped at one angle",
        "stiffness_hardening",
        "linear penalty contact",
        {{"q_lim", "rad", 0.0, -1e3, 1e3, "where the contact begins", Scale::reach, {0.7, -0.7}},
         {"k", "N m/rad", 0.0, -1e9, 1e9, "contact stiffness; negative: a lower stop", Scale::stiffness, {1.0, -1.0}}}};
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    const T beyond = s.q - p[0];
    return T(0.0) - p[1] * select(p[1] > T(0.0), max(beyond, T(0.0)), T(0.0) - min(beyond, T(0.0)));
  }
};

}  // namespace lacuna
