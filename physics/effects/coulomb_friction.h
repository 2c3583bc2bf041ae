#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Dry friction of constant size. Exact sign: the rollout finds the instants of sticking and breaking away.
struct CoulombFriction {
  static EffectInfo info() {
    return {"coulomb_friction", "Coulomb friction", Where::joint,
            "tau -= Fc sgn(v); at rest up to Fc holds",
            "an offset that flips with the direction of motion; flat spots at reversals",
            "damping, valve_deadband",
            "C.-A. de Coulomb 1785; Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994)",
            {{"Fc", "N m", 0.0, 0.0, 1e9, "friction effort", Scale::effort, {0.05}}}};
  }
  template <class T>
  static T dry_friction(const T* p, const T&, const JointView<T>&) {
    return p[0];
  }
};

}  // namespace lacuna
