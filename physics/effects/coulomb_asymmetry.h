#pragma once

#include "physics/effects/creep.h"

namespace lacuna {

/// Dry friction of another size in either direction: Fc_up against motion and pull in the joint's positive direction,
/// Fc_down against the other. The same as coulomb_friction of their mean beside a torque_offset of -(Fc_up -
/// Fc_down)/2. v0 as in creep.h. Neutral at 0, 0.
struct CoulombAsymmetry {
  static EffectInfo info() {
    EffectInfo info{
        "coulomb_asymmetry",
        "Asymmetric Coulomb friction",
        Where::joint,
        Stage::link,
        "tau -= Fc_up for v > 0, tau += Fc_down for v < 0, at rest up to these hold; with v0 > 0: times tanh(|v|/v0)",
        "an offset that flips with the direction of motion by unequal amounts",
        "coulomb_friction, valve_offset, torque_offset",
        "B. Armstrong-Helouvry, Control of Machines with Friction, 1991, ch. 4 (direction dependence)",
        {{"Fc_up", "N m", 0.0, 0.0, 1e9, "friction effort in positive motion", Scale::effort, {0.06}},
         {"Fc_down", "N m", 0.0, 0.0, 1e9, "friction effort in negative motion", Scale::effort, {0.04}},
         creep_speed()}};
    info.in_efforts = true;
    info.generalises = "coulomb_friction";
    return info;
  }
  static constexpr bool directed = true;
  template <class T>
  static T dry_friction(const T* p, const T&, const JointView<T>& s) {
    return select(p[kV0] > T(0.0), T(0.0), size(p, s.direction));
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return creeping(size(p, s.v), p[kV0], s.v);
  }

 private:
  enum { kUp, kDown, kV0 };
  template <class T>
  static T size(const T* p, const T& direction) {
    return select(direction < T(0.0), p[kDown], p[kUp]);
  }
};

}  // namespace lacuna
