#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Friction in proportion to speed, of bearings, gears and seals. Besides an actuator's own damping it is what a plant
/// lacks whose actuator has none. Neutral at D = 0.
struct ViscousFriction {
  static EffectInfo info() {
    EffectInfo info{"viscous_friction",
                    "Viscous friction",
                    Where::joint,
                    Stage::link,
                    "tau -= D v",
                    "error in proportion to speed",
                    "damping, actuator_lag",
                    "B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994)",
                    {{"D", "N m s/rad", 0.0, 0.0, 1e9, "effort per speed", Scale::damping, {0.1}}}};
    info.in_efforts = true;
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return T(0.0) - p[0] * s.v;
  }
  template <class T>
  static T loss(const T* p) {
    return p[0];
  }
};

}  // namespace lacuna
