#pragma once

#include "physics/effects/creep.h"

namespace lacuna {

/// Dry friction that is larger at break-away than in motion. Neutral at Fc = Fs = 0; Fs = Fc is Coulomb friction. v0 as
/// there. No contact breaks away at less than it slides at: an Fs below Fc is refused by a scenario, and counts as Fc
/// here.
struct StribeckFriction {
  static EffectInfo info() {
    EffectInfo info{
        "stribeck_friction",
        "Stribeck friction",
        Where::joint,
        Stage::link,
        "tau -= (Fc + (Fs - Fc) exp(-(v/vs)^2)) sgn(v)",
        "extra friction at low speed, stick-slip",
        "coulomb_friction",
        "R. Stribeck 1902; Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994)",
        {{"Fc", "N m", 0.0, 0.0, 1e9, "friction effort in fast motion", Scale::effort, {0.05}},
         {"Fs", "N m", 0.0, 0.0, 1e9, "break-away effort", Scale::effort, {0.08}},
         {"vs", "rad/s", 0.05, 1e-5, 1e3, "speed over which the extra friction fades", Scale::velocity, {0.1, 0.4}},
         creep_speed()}};
    info.parameters[kFs].at_least = "Fc";
    return info;
  }
  template <class T>
  static T dry_friction(const T* p, const T& speed, const JointView<T>&) {
    return select(p[kV0] > T(0.0), T(0.0), size(p, speed));
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return creeping(size(p, s.v), p[kV0], s.v);
  }

 private:
  enum { kFc, kFs, kVs, kV0 };
  template <class T>
  static T size(const T* p, const T& speed) {
    const T ratio = speed / p[kVs];
    return p[kFc] + max(p[kFs] - p[kFc], T(0.0)) * exp(T(0.0) - min(ratio * ratio, T(700.0)));
  }
};

}  // namespace lacuna
