#pragma once

#include "physics/effects/creep.h"

namespace lacuna {

/// Friction that grows with the load on the joint: what the drive gives but for its viscous part, which is lost before
/// it loads anything. Neutral at mu = 0. v0 as in creep.h.
struct LoadDependentFriction {
  static EffectInfo info() {
    return {"load_dependent_friction",
            "Load-dependent friction",
            Where::joint,
            Stage::link,
            "tau -= mu |load| sgn(v), load: effort of the drive without its damping",
            "friction that grows with the load",
            "coulomb_friction",
            "P. Hamon, M. Gautier, P. Garrec, Dynamic identification of robots with a dry friction model depending on "
            "load, IROS 2010",
            {{"mu", "1", 0.0, 0.0, 0.5, "share of the load", Scale::ratio, {0.05}}, creep_speed()}};
  }
  static constexpr bool loaded = true;
  template <class T>
  static T dry_friction(const T* p, const T&, const JointView<T>& s) {
    return select(p[1] > T(0.0), T(0.0), p[0] * abs(s.load));
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return creeping(p[0] * abs(s.load), p[1], s.v);
  }
};

}  // namespace lacuna
