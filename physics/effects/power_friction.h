#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Friction that grows with a power of the speed below 1, as harmonic drives and lubricated seals show. The power's
/// infinite slope at rest is rounded off over speeds of about v0, where friction is c v0^(p - 1) v: |v|^p becomes
/// |v| (v^2 + v0^2)^((p - 1)/2), which is 1 % off at 7 v0 (p = 1/2). Neutral at c = 0.
struct PowerFriction {
  static EffectInfo info() {
    ParameterInfo rounding{"v0", "rad/s", 0.01, 1e-6, 1e3, "speed below which it is linear", Scale::velocity, {0.03}};
    rounding.optional = true;
    EffectInfo info{
        "power_friction",
        "Power-law friction",
        Where::joint,
        Stage::link,
        "tau -= c |v|^p sgn(v), linear below about v0",
        "friction that grows with speed, and the less the faster",
        "viscous_friction, coulomb_friction",
        "W. Ostwald 1925 (power law of lubricants); harmonic drives: T. D. Tuttle, W. P. Seering, IEEE Trans. Robotics "
        "Autom. 12 (1996)",
        {{"c", "N m (s/rad)^p", 0.0, 0.0, 1e9, "friction effort at 1 rad/s", Scale::effort, {0.05}},
         {"p", "1", 0.5, 0.25, 0.99, "power of the speed; near 0 it would be dry friction", Scale::ratio, {0.5}},
         rounding}};
    info.in_efforts = true;
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    const T square = s.v * s.v + p[kV0] * p[kV0];
    return T(0.0) - p[kC] * s.v * exp(T(0.5) * (p[kP] - T(1.0)) * log(square));
  }

 private:
  enum { kC, kP, kV0 };
};

}  // namespace lacuna
