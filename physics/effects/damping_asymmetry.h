#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Damping that differs with the direction of motion (unequal areas, check valves, lips of seals). It takes effort in
/// proportion to the joint's speed, as friction does, and so acts behind an effort that is measured. Neutral at a = 0.
struct DampingAsymmetry {
  static EffectInfo info() {
    EffectInfo info{
        "damping_asymmetry",
        "Damping asymmetry",
        Where::joint,
        Stage::link,
        "damping -> (1 + a) damping for v < 0",
        "one direction slower",
        "valve_offset, valve_asymmetry",
        "H. E. Merritt, Hydraulic Control Systems, 1967, ch. 6 (single-rod cylinders)",
        {{"a", "1", 0.0, -1.0, 100.0, "share by which negative motion is damped more", Scale::ratio, {0.2}}}};
    info.hydraulic = true;
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    return T(0.0) - p[0] * s.damping * min(s.v, T(0.0));
  }
};

}  // namespace lacuna
