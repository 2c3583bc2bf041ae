#pragma once

#include "physics/catalogue.h"

namespace lacuna {

/// Effort that comes and goes n times a turn: cogging, eccentric gears, a harmonic drive's two waves. Neutral at
/// a = b = 0.
struct GearRipple {
  static EffectInfo info() {
    EffectInfo info{
        "gear_ripple",
        "Gear ripple",
        Where::joint,
        Stage::transmission,
        "tau += a sin(n q) + b cos(n q)",
        "error that repeats with the joint's angle, over and over",
        "lever_arm_variation, gravity_spring",
        "P. S. Gandhi, F. H. Ghorbel, J. Dabney, Friction in harmonic drives, CDC 2002; B. Armstrong-Helouvry, "
        "Control of Machines with Friction, 1991 (position dependence)",
        {{"a", "N m", 0.0, -1e9, 1e9, "sine part", Scale::effort, {0.02}},
         {"b", "N m", 0.0, -1e9, 1e9, "cosine part", Scale::effort, {0.02}},
         {"n",
          "1/rad",
          1.0,
          1e-3,
          1e4,
          "angle of the ripple per angle of the joint: periods a turn",
          Scale::wave,
          {1.3, 3.3, 8.0, 20.0}}}};
    info.in_efforts = true;
    info.in_parallel = true;  // a counterbalance goes round once, gears many times
    return info;
  }
  template <class T>
  static T effort(const T* p, const JointView<T>& s) {
    T sine, cosine;
    sincos(p[kN] * s.q, sine, cosine);
    return p[kA] * sine + p[kB] * cosine;
  }

 private:
  enum { kA, kB, kN };
};

}  // namespace lacuna
