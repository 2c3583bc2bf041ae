#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A counterbalance: a weight, or a spring on a crank, that pulls the joint towards an angle q0 with k sin(q - q0).
/// Given by a = k cos(q0) and b = -k sin(q0), in which it is linear. Neutral at 0, 0. Of a sliding joint the angle is
/// its way in metres.
struct GravitySpring {
  static EffectInfo info() {
    EffectInfo info{"gravity_spring",
                    "Counterbalance",
                    Where::joint,
                    Stage::link,
                    "tau -= a sin(q) + b cos(q)",
                    "an effort that goes round with the joint's angle, as gravity does",
                    "link masses, com_shift, stiffness",
                    "gravity compensators of heavy industrial robots: A. Klimchik et al., ICRA 2013",
                    {{"a", "N m", 0.0, -1e9, 1e9, "sine part", Scale::effort, {0.05}},
                     {"b", "N m", 0.0, -1e9, 1e9, "cosine part", Scale::effort, {0.05}}}};
    info.in_efforts = true;
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    T sine, cosine;
    sincos(s.q, sine, cosine);
    return T(0.0) - p[0] * sine - p[1] * cosine;
  }
};

}  // namespace lacuna
