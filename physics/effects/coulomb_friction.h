#pragma once

#include "physics/effects/creep.h"

namespace lacuna {

/// Dry friction of constant size. With v0 = 0 the sign is exact and the rollout finds the instants of sticking and
/// breaking away; with v0 > 0 the contact creeps: friction builds up over speeds of about v0, as lubricated contacts
/// do.
struct CoulombFriction {
  static EffectInfo info() {
    return {"coulomb_friction",
            "Coulomb friction",
            Where::joint,
            Stage::link,
            "tau -= Fc sgn(v), at rest up to Fc holds; with v0 > 0: tau -= Fc tanh(v/v0)",
            "an offset that flips with the direction of motion; flat spots at reversals",
            "damping, valve_deadband",
            "C.-A. de Coulomb 1785; Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994)",
            {{"Fc", "N m", 0.0, 0.0, 1e9, "friction effort", Scale::effort, {0.05}}, creep_speed()}};
  }
  template <class T>
  static T dry_friction(const T* p, const T&, const JointView<T>&) {
    return select(p[1] > T(0.0), T(0.0), p[0]);
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return creeping(p[0], p[1], s.v);
  }
};

}  // namespace lacuna
