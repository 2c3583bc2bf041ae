#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// A spring that stiffens (or softens) towards the ends of travel. Neutral at k3 = 0.
struct StiffnessHardening {
  static EffectInfo info() {
    return {"stiffness_hardening",
            "Stiffness hardening",
            Where::joint,
            Stage::link,
            "tau -= k3 (q - rest)^3",
            "error at the ends of travel",
            "stiffness, end_stop",
            "G. Duffing 1918, Erzwungene Schwingungen",
            {{"k3", "N m/rad^3", 0.0, -1e12, 1e12, "cubic stiffness", Scale::hardening, {0.1}}}};
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    const T way = s.q - s.rest;
    return T(0.0) - p[0] * way * way * way;
  }
};

}  // namespace lacuna
